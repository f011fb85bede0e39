// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Geometry>
#include <limits>
#include <memory>
#include <vector>

#include "palpate/registration/pose.hpp"
#include "registration/pair_columns.hpp"

namespace palpate::registration {

/// What a pose's inliers gain: 1 - (residual / bound)^2 each, and with normals less their squared
/// chord over its bound. N minus the gain is the truncated least-squares cost in squared bounds.
struct Score {
  double gain = 0;
  int count = 0;  ///< correspondences that gain
};

/// Correspondences one axis after the other in single precision, about their means and in units of
/// the noise bound, for poses in those coordinates.
class Scorer {
 public:
  /// @param chord_bound  largest chord between an inlier's normals; 0 for no normals
  /// @param turns  among which align() looks
  Scorer(const Correspondences& correspondences, double noise_bound, double chord_bound,
         const AllowedTurns& turns = {});

  int size() const { return columns_->size(); }
  int dimensions() const { return chord_bound_ > 0 ? 5 : 3; }
  double chord_bound() const { return static_cast<double>(chord_bound_); }

  /// Relative to the means, in noise bounds.
  const PairColumns& columns() const { return *columns_; }

  double gain(const Eigen::Isometry3d& T) const;
  /// Of some correspondences alone.
  double gain_of(const std::vector<int>& indices, const Eigen::Isometry3d& T) const;
  Score score(const Eigen::Isometry3d& T) const;
  /// Counts correspondences of equal points once; of more than some hundred inliers all.
  Score score_of_distinct(const Eigen::Isometry3d& T) const;

  /// Counts inliers that lie within `radius` bounds of one another in both frames once, up to so
  /// many that chance is out of the question.
  /// @param looked  at so many of them at most
  Score score_of_separate(const Eigen::Isometry3d& T, float radius,
                          std::size_t looked = std::numeric_limits<std::size_t>::max()) const;

  /// Other pairs in the same coordinates, which must outlive the result.
  Scorer over(const PairColumns& columns) const;

  /// The same pairs by their positions alone.
  Scorer without_normals() const;

  /// The correspondences whose residuals are at most `reach` times the bounds, ascending.
  std::vector<int> near(const Eigen::Isometry3d& T, float reach) const;

  /// Alternates inliers and least squares, from T until the gain grows no more. From a reflection
  /// it leads to reflections.
  /// @param reach  times the bounds are those meant by inliers and gain
  /// @return gain reached
  double descend(Eigen::Isometry3d& T, float reach = 1) const;

  /// Least-squares pose of some correspondences.
  Eigen::Isometry3d align(const std::vector<int>& indices) const;

  /// The same for a reflection: the source's mirror image, turned and shifted.
  Eigen::Isometry3d align_mirrored(const std::vector<int>& indices) const;

  /// Pairs within `reach` times the bounds if every source is paired with the target `shift` places
  /// on.
  int count_shifted(const Eigen::Isometry3d& T, int shift, float reach = 1) const;

  /// The pose in the coordinates of the correspondences.
  Eigen::Isometry3d uncentred(const Eigen::Isometry3d& T) const;
  /// The opposite.
  Eigen::Isometry3d centred(const Eigen::Isometry3d& T) const;

 private:
  /// Squared residuals of position and, with normals, chord, in squared bounds.
  Eigen::ArrayXf squares(const Eigen::Isometry3d& T, int from, int to, int shift) const;
  void squares(const Eigen::Isometry3d& T, int from, int to, int shift, float* result) const;
  int count_within(const Eigen::Isometry3d& T, int from, int to, int shift, float reach) const;
  Eigen::ArrayXf gains(const Eigen::Isometry3d& T, float reach = 1) const;
  Eigen::Isometry3d align_inliers(const Eigen::ArrayXf& gains, double sign) const;
  Eigen::Isometry3d align(const std::vector<int>& indices, double sign) const;

  double unit_ = 1;
  float chord_bound_ = 0;
  AllowedTurns turns_;  // its axis a unit vector
  Eigen::Vector3d source_origin_ = Eigen::Vector3d::Zero();
  Eigen::Vector3d target_origin_ = Eigen::Vector3d::Zero();
  std::shared_ptr<const PairColumns> columns_;  // of copies the same
};

}  // namespace palpate::registration
