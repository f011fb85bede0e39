// SPDX-License-Identifier: Apache-2.0
#include "skills/grasp/pressing.hpp"

#include <algorithm>

namespace palpate::skills {

grasping::Load weight_at(const Executor& robot, const Eigen::Isometry3d& T_world_object,
                         double weight) {
  const Eigen::Isometry3d T_base_world = robot.reading().base.pose().inverse();
  return {T_base_world * T_world_object.translation(), -weight * T_base_world.linear().col(2)};
}

hand::ActuatorVector pressing_command(const Executor& robot,
                                      std::span<const tactile::Contact> contacts,
                                      std::span<const Eigen::Vector3d> forces) {
  const hand::HandReading& reading = robot.reading();
  const auto torques = grasping::pressing_torques(robot.model(), reading.joints, contacts, forces);
  hand::ActuatorVector command = robot.command().positions;
  for (Eigen::Index i = 0; i < command.size(); ++i) {
    const auto& actuator = robot.actuators()[static_cast<std::size_t>(i)];
    if (torques[i] == 0) continue;
    const double lead = (torques[i] - reading.torques[i]) / actuator.stiffness;
    command[i] = std::clamp(command[i] + lead, actuator.command.low, actuator.command.high);
  }
  return command;
}

}  // namespace palpate::skills
