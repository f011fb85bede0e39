// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <mujoco/mujoco.h>

#include <optional>
#include <string>
#include <vector>

#include "palpate/simulation/hand/describe_hand.hpp"

namespace palpate::simulation {

/// Largest torque of the file's actuators on a joint, N m: the least of the joint's own limit and
/// of what an actuator's force range, its gain and command range, and its gear allow. 0 where the
/// file does not say.
double torque_limit(const mjModel& model, int joint);

/// Where the commands of a position actuator move a joint to, rad; nothing without one.
std::optional<hand::Range> commanded_range(const mjModel& model, int joint);

/// Ends an actuator's range where the file's commands end, if that leaves a fifth to nine tenths of
/// it; commands of exactly -1..1 are the default of many a file, and no limit.
/// @return what was done, in words; empty if nothing
std::string limit_by_commands(const mjModel& model, int joint, hand::Actuator& actuator);

/// The range of an actuator's first joint in which the joints that follow it keep to theirs, within
/// 0.1 rad; empty if there is none.
hand::Range range_with_followers(const hand::Description& hand, const hand::Actuator& actuator);

/// @param finger_of_joint  -1: of none
/// @return which finger has no drive of its own, in words; empty if all have one
/// @throws BadInput if less than two fingers have one
std::string led_fingers(const hand::Description& hand, const std::vector<int>& finger_of_joint);

constexpr double kTipStiffness = 300;  ///< N/m, of a servo at the fingertip

/// Gives every actuator its lever, and a servo as stiff at the fingertip as kTipStiffness, within
/// 0.5 to 12 N m/rad, critically damped.
/// @param joint_ids  in the model, of the hand's joints
/// @param positions  at which the levers are measured
void set_gains(const mjModel& model, const std::vector<int>& joint_ids,
               const hand::ActuatorVector& positions, hand::Description& hand);

/// Drives that cannot do what picks need: that press too little to hold or too much to sense, do
/// not carry what is on them, or hardly accelerate it; and a hand that is too heavy.
/// @param given  whether the user chose the torque limits
std::vector<HandProblem> check_drives(const mjModel& model, const std::vector<int>& joint_ids,
                                      bool given, const hand::Description& hand);

/// Lowers torque limits that are no real ones, as the effort="10" of many a URDF: where a drive
/// that closes a finger would press with more than 60 N, every drive gets the torque of 18 N at
/// the fingertip.
/// @return what was done, in words; empty if nothing
std::string lower_torque_limits(hand::Description& hand);

}  // namespace palpate::simulation
