// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>

#include "palpate/grasping/force_distribution.hpp"
#include "palpate/skills/executor.hpp"

namespace palpate::skills {

/// The object's weight (N) at its centre, in the mount's frame.
grasping::Load weight_at(const Executor& robot, const Eigen::Isometry3d& T_world_object,
                         double weight);

/// Commands with which the fingertips press so. They are meant to stay as they are: against stiff
/// fingers an object that moves meets a growing resistance, where limited torques would let it go.
/// Actuators that need no torque for it keep their commands.
///
/// @param contacts  as the hand is now, mount's frame
/// @param forces  one a contact, N, of the finger on the object, mount's axes
hand::ActuatorVector pressing_command(const Executor& robot,
                                      std::span<const tactile::Contact> contacts,
                                      std::span<const Eigen::Vector3d> forces);

/// Torques with which the actuators bear what the fingertips sense now, N m. What the actuators
/// themselves report holds their friction, too, and is used only where no fingertip reports a
/// force.
hand::ActuatorVector contact_torques(const Executor& robot);

}  // namespace palpate::skills
