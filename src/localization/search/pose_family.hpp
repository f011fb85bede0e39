// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Geometry>
#include <vector>

#include "localization/search/symmetry_group.hpp"
#include "palpate/localization/posterior.hpp"

namespace palpate::localization {

/// A pose as the clustering compares it.
struct PosePoint {
  Eigen::Quaterniond q;
  Eigen::Vector3d t;

  explicit PosePoint(const Eigen::Isometry3d& T)
      : q(Eigen::Quaterniond(T.linear()).normalized()), t(T.translation()) {}
  PosePoint(const Eigen::Quaterniond& rotation, const Eigen::Vector3d& translation)
      : q(rotation), t(translation) {}
  Eigen::Isometry3d isometry() const { return Eigen::Translation3d(t) * q; }
};

/// The poses of a mode: one pose, or its turns about a free axis. Copies of the object turned by a
/// symmetry are the same pose.
class PoseFamily {
 public:
  using Symmetries = SymmetryGroup;

  explicit PoseFamily(PosePoint pose) : pose_(std::move(pose)) {}
  PoseFamily(PosePoint pose, FreeAxis axis) : pose_(std::move(pose)), axis_(std::move(axis)) {}

  const PosePoint& pose() const { return pose_; }
  const std::optional<FreeAxis>& axis() const { return axis_; }

  /// The family's member nearest to some pose.
  struct Match {
    PosePoint image;   ///< the pose's copy that was compared
    double along = 0;  ///< turn of the nearest member about the free axis, rad
    PoseError error;
  };
  Match match(const PosePoint& pose, const Symmetries& symmetries) const;

  /// Whether match(pose).error is within the tolerance; faster.
  bool contains(const PosePoint& pose, const Symmetries& symmetries,
                const PoseTolerance& tolerance = {}) const;

  /// The member turned by `angle` about the free axis.
  PosePoint at(double angle) const;

 private:
  Match match_image(const PosePoint& image) const;
  Match match_turns(const PosePoint& pose, const Symmetries& symmetries) const;

  PosePoint pose_;
  std::optional<FreeAxis> axis_;
};

PoseFamily family_of(const Mode& mode);

/// The covariance of a mode with a free axis, where the turns about that have this standard
/// deviation, rad.
Matrix6d covariance_along(const Mode& mode, double spread);

/// Removes from `poses` what the family holds and returns how many that were.
std::size_t take(const PoseFamily& family, const PoseFamily::Symmetries& symmetries,
                 std::vector<PosePoint>& poses);

/// The larger of the two errors, each relative to its tolerance.
double relative_error(const PoseError& error, const PoseTolerance& tolerance = {});

}  // namespace palpate::localization
