// SPDX-License-Identifier: Apache-2.0
#include "skills/grasp/pressing.hpp"

#include <algorithm>
#include <vector>

namespace palpate::skills {

grasping::Load weight_at(const Executor& robot, const Eigen::Isometry3d& T_world_object,
                         double weight) {
  const Eigen::Isometry3d T_mount_world = robot.reading().mount.pose().inverse();
  return {T_mount_world * T_world_object.translation(), -weight * T_mount_world.linear().col(2)};
}

namespace {

constexpr std::size_t kAveragedReadings = 5;

hand::ActuatorVector torques_of_contacts(const hand::Description& hand,
                                         const hand::HandReading& reading) {
  const auto T_mount_link = hand::forward_kinematics(hand, reading.joints);
  std::vector<tactile::Contact> contacts;
  std::vector<Eigen::Vector3d> forces;
  for (std::size_t finger = 0; finger < reading.contacts.size(); ++finger) {
    const auto& T = T_mount_link[static_cast<std::size_t>(hand.fingers[finger].link)];
    for (const hand::TipContact& tip_contact : reading.contacts[finger]) {
      tactile::Contact contact;
      contact.finger = static_cast<int>(finger);
      contact.p = T * tip_contact.p;
      contact.n = T.linear() * tip_contact.n;
      contacts.push_back(contact);
      forces.push_back(T.linear() * tip_contact.f);
    }
  }
  return grasping::pressing_torques(hand, reading.joints, contacts, forces);
}

}  // namespace

hand::ActuatorVector contact_torques(const Executor& robot) {
  const std::span<const hand::HandReading> readings(robot.log().readings);
  const auto window = readings.last(std::min(readings.size(), kAveragedReadings));
  hand::ActuatorVector sum = hand::ActuatorVector::Zero(robot.model().actuator_count());
  for (const auto& reading : window) sum += torques_of_contacts(robot.model(), reading);
  if (sum.isZero(0)) return robot.reading().torques;
  return sum / static_cast<double>(window.size());
}

hand::ActuatorVector pressing_command(const Executor& robot,
                                      std::span<const tactile::Contact> contacts,
                                      std::span<const Eigen::Vector3d> forces) {
  const hand::HandReading& reading = robot.reading();
  const auto torques = grasping::pressing_torques(robot.model(), reading.joints, contacts, forces);
  const hand::ActuatorVector sensed = contact_torques(robot);
  hand::ActuatorVector command = robot.command().positions;
  for (Eigen::Index i = 0; i < command.size(); ++i) {
    const auto& actuator = robot.actuators()[static_cast<std::size_t>(i)];
    if (torques[i] == 0) continue;
    const bool trusted = actuator.finger < 0 || robot.trust().trusted(actuator.finger);
    const double now = trusted ? sensed[i] : robot.reading().torques[i];
    const double lead = (torques[i] - now) / actuator.stiffness;
    command[i] = std::clamp(command[i] + lead, actuator.command.low, actuator.command.high);
  }
  return command;
}

}  // namespace palpate::skills
