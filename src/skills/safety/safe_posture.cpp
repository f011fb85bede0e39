// SPDX-License-Identifier: Apache-2.0
#include "skills/safety/safe_posture.hpp"

#include <algorithm>
#include <cmath>

#include "palpate/hand/kinematics.hpp"
#include "skills/safety/command_gate.hpp"

namespace palpate::skills {
namespace {

constexpr double kTurnLever = 0.2;  // m: the mount's turns give way at the speed over this

}  // namespace

hand::HandCommand with_eased_mount(const hand::HandCommand& command,
                                   const hand::HandReading& reading, const SafetyOptions& options) {
  hand::HandCommand next = command;
  const double step = options.release_speed * hand::kTick;
  next.mount.xyz = limited_step(command.mount.xyz, reading.mount.xyz, step);
  next.mount.ypr = limited_step(command.mount.ypr, reading.mount.ypr, step / kTurnLever);
  return next;
}

hand::HandCommand with_eased_fingers(const hand::HandCommand& command,
                                     const hand::HandReading& reading,
                                     const hand::Description& hand, const SafetyOptions& options) {
  hand::HandCommand next = command;
  const hand::ActuatorVector positions = hand::actuator_positions(hand, reading.joints);
  for (int i = 0; i < hand.actuator_count(); ++i) {
    const auto& actuator = hand.actuators[static_cast<std::size_t>(i)];
    const double lead = options.rest_torque / actuator.stiffness;
    const double eased = std::clamp(command.positions[i], positions[i] - lead, positions[i] + lead);
    const double most = options.finger_speed * hand::kTick;
    next.positions[i] += std::clamp(eased - command.positions[i], -most, most);
  }
  return next;
}

}  // namespace palpate::skills
