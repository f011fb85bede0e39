// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "palpate/geometry/cloud/kd_tree.hpp"
#include "palpate/geometry/cloud/point_cloud.hpp"
#include "palpate/registration/cloud_registration.hpp"
#include "palpate/registration/pose.hpp"

namespace palpate::registration {

/// Adds point i of the source with point j of the target, both with normals.
void append_pair(Correspondences& pairs, const geometry::PointCloud& source, std::size_t i,
                 const geometry::PointCloud& target, std::size_t j);

/// Mutual matches of features, with the points' normals.
Correspondences matched_features(const FeatureCloud& source, const FeatureCloud& target,
                                 int threads);

/// Nearest neighbours of one cloud in another, round after round; the lists' memory is used again,
/// and a round looks no farther than the partners of the one before.
class NeighbourRounds {
 public:
  /// @param source, target  with normals, of either sign; they must outlive this
  NeighbourRounds(const geometry::PointCloud& source, const geometry::PointCloud& target,
                  Primitive primitive, const AllowedTurns& turns, int threads);

  /// Pairs every stride-th source point, moved, with its nearest target point, where that is within
  /// the bound and their normals do not part by more than 60 deg, of whichever sign.
  const Correspondences& pair_up(const Eigen::Isometry3d& T, double bound, std::size_t stride);

  const Correspondences& pairs() const { return pairs_; }
  std::size_t source_size() const { return source_.size(); }
  /// Of the pairs; planes have the mean of both points' normals, at the pose they were paired at.
  PoseEstimate solve();

  /// Share of the source's points that have a partner.
  double overlap() const {
    return static_cast<double>(pairs_.size()) / static_cast<double>(looked_);
  }

  /// Share of the source's points that have a target point within the bound at T, whatever their
  /// normals.
  double share_within(const Eigen::Isometry3d& T, double bound) const;

  /// Of every stride-th source point at T that lies on the target's surface (within the bound of a
  /// point) or above or below it (within three bounds, along the normals of both), the share that
  /// lies above or below. What lies beside the target says nothing: more of it may be out of sight.
  double share_off_surface(const Eigen::Isometry3d& T, double bound, std::size_t stride) const;

  /// Of each source point, paired up at the pose within `reach`, min(r^2 / bound^2, 1), r the
  /// residual of the primitive; 1 of those without a partner.
  std::vector<double> truncated_costs(const Eigen::Isometry3d& T, double reach, double bound);

  /// Mean over the source's points that were looked at of min(r^2 / bound^2, 1), r the residual of
  /// the primitive at the pose that they were paired up at.
  double truncated_cost(const Eigen::Isometry3d& T, double bound) const;

 private:
  void find_nearest(const Eigen::Isometry3d& T, double bound, std::size_t stride);
  int nearest_within(const Eigen::Vector3d& p, double bound, int last) const;

  const geometry::PointCloud& source_;
  const geometry::PointCloud& target_;
  geometry::KdTree tree_;
  Primitive primitive_;
  AllowedTurns turns_;
  int threads_;
  std::vector<int> nearest_, partners_;  // of every source point, with normals alike or not; or -1
  std::size_t looked_ = 0;
  Eigen::Isometry3d paired_at_ = Eigen::Isometry3d::Identity();
  std::vector<Eigen::Vector3d>
      own_normals_;  // of the target's points, while the mean ones stand in
  Correspondences pairs_;
};

}  // namespace palpate::registration
