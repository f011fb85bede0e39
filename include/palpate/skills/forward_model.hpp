// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Geometry>
#include <array>
#include <memory>
#include <span>

#include "palpate/geometry/objects/known_object.hpp"
#include "palpate/hand/hand.hpp"
#include "palpate/hand/kinematics.hpp"
#include "palpate/planning/collision_checker.hpp"
#include "palpate/planning/fixture.hpp"

namespace palpate::skills {

/// A grasp as the robot believes it to be: what it commands, what it measures, what it estimates.
struct BelievedGrasp {
  hand::HandCommand command;
  hand::JointVector joints;  ///< rad
  Eigen::Isometry3d T_world_object = Eigen::Isometry3d::Identity();
};

/// How a motion of the fingers is predicted to end, without noise.
struct RolloutOutcome {
  Eigen::Isometry3d T_mount_object = Eigen::Isometry3d::Identity();
  hand::PerFinger<double> tip_forces{};  ///< N, normal, of each finger
  bool diverged = false;
};

/// Predicts what a motion of the fingers does to the object, from what is believed: the object's
/// mesh, the believed hand, and the estimated pose.
///
/// Each thread needs a model of its own; the same grasp and motion give the same outcome in all of
/// them.
class ForwardModel {
 public:
  virtual ~ForwardModel() = default;

  /// Puts hand and object where they are believed to be, and waits until they have settled.
  /// @return the settled grasp, from which every rollout starts
  /// @throws BadInput for values that are not finite
  virtual RolloutOutcome settle(const BelievedGrasp& grasp, double seconds) = 0;

  /// Rolls a motion out, one command a tick, from the settled grasp.
  /// @throws BadInput before the first settle(), or for an empty motion
  virtual RolloutOutcome rollout(std::span<const hand::HandCommand> motion) = 0;
};

/// Makes the models of the world that skills plan with. What they are built from is handed over:
/// the believed hand and the known object; the real or simulated plant is not.
class ModelFactory {
 public:
  virtual ~ModelFactory() = default;

  /// @throws BadInput for a hand or an object that cannot be used
  [[nodiscard]] virtual std::unique_ptr<planning::CollisionChecker> collision_checker(
      const geometry::KnownObject& object, const hand::Description& believed,
      const planning::CollisionOptions& options, const planning::Fixture& fixture) const = 0;

  /// @throws BadInput for a hand or an object that cannot be used
  [[nodiscard]] virtual std::unique_ptr<ForwardModel> forward_model(
      const geometry::KnownObject& object, const hand::Description& believed) const = 0;
};

}  // namespace palpate::skills
