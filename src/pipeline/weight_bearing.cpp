// SPDX-License-Identifier: Apache-2.0
#include "weight_bearing.hpp"

#include <algorithm>
#include <span>

#include "load.hpp"
#include "palpate/touch/contact_window.hpp"

namespace palpate::pipeline {
namespace {

constexpr std::size_t kReadings = 20;

double press_of(const std::vector<touch::Contact>& contacts) {
  double sum = 0;
  for (const auto& contact : contacts) sum += std::max(0.0, -contact.f.dot(contact.n));
  return sum;
}

}  // namespace

WeightBearing::WeightBearing(const Robot& robot, const Eigen::Vector3d& p_base_object,
                             double weight, double friction, double grip)
    : robot_(robot),
      positions_(robot.command().positions),
      p_base_object_(p_base_object),
      weight_(weight),
      friction_(friction),
      grip_(grip) {
  const std::span<const hand::HandReading> readings(robot.log().readings);
  const auto window = readings.last(std::min(readings.size(), kReadings));
  contacts_ = touch::lasting_contacts(window, robot.model(), {});
  joints_ = touch::mean_joints(window);
  press_ = press_of(contacts_);
  torques_ = torques(robot.reading().base, press_);
}

hand::ActuatorVector WeightBearing::torques(const hand::BasePosition& base, double press) const {
  if (press <= 0) return hand::ActuatorVector::Zero();
  const Load load{p_base_object_, -weight_ * base.pose().linear().row(2).transpose()};
  const auto balanced = balance_forces(contacts_, friction_, press, load);
  return pressing_torques(robot_.model(), joints_, contacts_, balanced.forces);
}

hand::ActuatorVector WeightBearing::command(const hand::BasePosition& base,
                                            double tightened) const {
  const double press = press_ * (1 + tightened * (grip_ - 1));
  const hand::ActuatorVector change = torques(base, press) - torques_;
  hand::ActuatorVector command = positions_;
  for (int i = 0; i < hand::kActuators; ++i) {
    const auto& actuator = robot_.actuators()[static_cast<std::size_t>(i)];
    if (change[i] == 0) continue;
    command[i] = std::clamp(command[i] + change[i] / actuator.stiffness, actuator.command.low,
                            actuator.command.high);
  }
  return command;
}

}  // namespace palpate::pipeline
