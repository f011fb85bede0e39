// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "palpate/grasping/force_distribution.hpp"
#include "palpate/skills/executor.hpp"

namespace palpate::skills {

/// How the fingers' commands follow the weight while the hand turns with what it holds.
///
/// Fingers are springs: where gravity comes to pull along another direction of the hand they give
/// way, the object moves with them, and its contacts wander. The forces that bear the weight as it
/// pulls then, within the friction cones of the contacts, are given to the fingers beforehand. Only
/// what changes is added to their commands: what they sensed when they pressed is left alone.
class WeightBearing {
 public:
  /// @param robot  holds the object, at rest
  /// @param p_mount_object  the object's centroid in the mount's frame, m
  /// @param weight  N
  /// @param friction  that the forces count on
  WeightBearing(const Executor& robot, const Eigen::Vector3d& p_mount_object, double weight,
                double friction);

  /// The fingers' commands for another attitude of the mount.
  [[nodiscard]] hand::ActuatorVector command(const hand::MountPosition& mount) const;

 private:
  [[nodiscard]] hand::ActuatorVector torques(const hand::MountPosition& mount) const;

  const Executor& robot_;
  std::vector<tactile::Contact> contacts_;
  hand::JointVector joints_;
  hand::ActuatorVector positions_, torques_;
  Eigen::Vector3d p_mount_object_;
  double weight_, friction_, press_ = 0;
};

}  // namespace palpate::skills
