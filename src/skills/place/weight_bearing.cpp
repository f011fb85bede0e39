// SPDX-License-Identifier: Apache-2.0
#include "skills/place/weight_bearing.hpp"

#include <algorithm>
#include <span>

#include "palpate/estimation/mean_load.hpp"
#include "palpate/tactile/contacts/contact_window.hpp"

namespace palpate::skills {
namespace {

constexpr std::size_t kReadings = 20;

double press_of(const std::vector<tactile::Contact>& contacts) {
  double sum = 0;
  for (const auto& contact : contacts) sum += std::max(0.0, -contact.f.dot(contact.n));
  return sum;
}

}  // namespace

WeightBearing::WeightBearing(const Executor& robot, const Eigen::Vector3d& p_mount_object,
                             double weight, double friction)
    : robot_(robot),
      positions_(robot.command().positions),
      p_mount_object_(p_mount_object),
      weight_(weight),
      friction_(friction) {
  const std::span<const hand::HandReading> readings(robot.log().readings);
  const auto window = readings.last(std::min(readings.size(), kReadings));
  contacts_ = tactile::contacts_with_normals(tactile::lasting_contacts(window, robot.model(), {}));
  joints_ = tactile::mean_joints(window);
  press_ = press_of(contacts_);
  torques_ = torques(robot.reading().mount);
}

hand::ActuatorVector WeightBearing::torques(const hand::MountPosition& mount) const {
  if (press_ <= 0) return hand::ActuatorVector::Zero(positions_.size());
  const grasping::Load load{p_mount_object_, -weight_ * mount.pose().linear().row(2).transpose()};
  const auto balanced = grasping::distribute_forces(contacts_, friction_, press_, load);
  return grasping::pressing_torques(robot_.model(), joints_, contacts_, balanced.forces);
}

hand::ActuatorVector WeightBearing::command(const hand::MountPosition& mount) const {
  const hand::ActuatorVector change = torques(mount) - torques_;
  hand::ActuatorVector command = positions_;
  for (Eigen::Index i = 0; i < command.size(); ++i) {
    const auto& actuator = robot_.actuators()[static_cast<std::size_t>(i)];
    if (change[i] == 0) continue;
    command[i] = std::clamp(command[i] + change[i] / actuator.stiffness, actuator.command.low,
                            actuator.command.high);
  }
  return command;
}

}  // namespace palpate::skills
