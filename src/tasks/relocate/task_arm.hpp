// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Geometry>
#include <string>

#include "palpate/core/se3.hpp"
#include "palpate/hand/hand.hpp"
#include "palpate/tasks/relocate/relocate_task.hpp"

namespace palpate::relocate {

inline constexpr int kArmJoints = 6;

/// Angles about x, y, z (rad), one after the other, each about the axis that the former have
/// turned.
Eigen::Vector3d xyz_angles(const Eigen::Matrix3d& R);

/// The arm that carries the task's hand: it slides along the axes of the resting forearm, and
/// then turns about the forearm's own x, y and z, one after the other. The hand's mount is at the
/// forearm's origin, with the world's axes where all joints are 0: the hand then points along y.
class TaskArm {
 public:
  explicit TaskArm(const RelocateModel& model);

  [[nodiscard]] Eigen::Matrix3d R_mount_forearm() const { return T_world_rest_.linear(); }

  /// @param q  of which the first six are the arm's (m, rad)
  [[nodiscard]] hand::MountPosition mount(const RelocateJoints& q) const;

  /// Joints of the arm (m, rad) that put the mount there, within their ranges or not.
  [[nodiscard]] Vector6d joints(const hand::MountPosition& mount) const;

  /// Which joint is beyond its range, in words; empty: none.
  [[nodiscard]] std::string obstacle(const Vector6d& joints) const;

 private:
  RelocateModel model_;  // shares the compiled model
  Eigen::Isometry3d T_world_rest_;
};

}  // namespace palpate::relocate
