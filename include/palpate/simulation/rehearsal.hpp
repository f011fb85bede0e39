// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <span>

#include "palpate/hand/kinematics.hpp"
#include "palpate/simulation/world.hpp"

namespace palpate::simulation {

/// A grasp as the robot believes it to be: what it commands, what it measures, what it estimates.
struct BelievedGrasp {
  hand::HandCommand command;
  hand::JointVector joints = hand::JointVector::Zero();  ///< rad
  Eigen::Isometry3d T_world_object = Eigen::Isometry3d::Identity();
};

/// A second world, made of what is known: the object's mesh and the hand's believed model. In it a
/// motion of the fingers is tried before it is made.
///
/// Each thread needs a rehearsal of its own; the same grasp and motion give the same outcome in
/// all of them.
class Rehearsal {
 public:
  /// How a motion ends, without noise.
  struct Outcome {
    Eigen::Isometry3d T_base_object = Eigen::Isometry3d::Identity();
    std::array<double, hand::kFingers> tip_forces{};  ///< N, normal, of each finger
    bool diverged = false;
  };

  /// @throws BadInput for options or an object that cannot be simulated
  Rehearsal(const geometry::KnownObject& object, const hand::HandModel& believed,
            const WorldOptions& options);
  ~Rehearsal();
  Rehearsal(Rehearsal&&) noexcept;

  /// Puts hand and object where they are believed to be, and waits until they have settled.
  /// @return the settled grasp, from which every motion starts
  /// @throws BadInput for values that are not finite
  Outcome start(const BelievedGrasp& grasp, double settle_seconds);

  /// Plays a motion, one command a tick, from the settled grasp.
  Outcome play(std::span<const hand::HandCommand> motion);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace palpate::simulation
