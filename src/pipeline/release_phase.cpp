// SPDX-License-Identifier: Apache-2.0
#include "palpate/pipeline/release_phase.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "palpate/pipeline/feel_phase.hpp"

namespace palpate::pipeline {
namespace {

constexpr double kDownSpeed = 0.10;   // m/s
constexpr double kUpSpeed = 0.30;     // m/s
constexpr double kFreeHeight = 0.34;  // m of the base
constexpr double kReach = 0.12;       // m from the origin: where the object can be at all

/// Mean place of the fingertip contacts felt last, if any was felt.
std::optional<Eigen::Vector2d> place_of_last_contacts(const Robot& robot) {
  const auto& readings = robot.log().readings;
  for (auto reading = readings.rbegin(); reading != readings.rend(); ++reading) {
    if (count_contacts(*reading) < 2) continue;
    const auto T_base_link = hand::forward_kinematics(robot.model(), reading->joints);
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    int count = 0;
    for (std::size_t finger = 0; finger < hand::kFingers; ++finger) {
      const auto link = static_cast<std::size_t>(robot.model().distal[finger]);
      for (const auto& contact : reading->contacts[finger]) {
        sum += T_base_link[link] * contact.p;
        ++count;
      }
    }
    return (reading->base.pose() * (sum / count)).head<2>();
  }
  return std::nullopt;
}

hand::BasePosition at_height(hand::BasePosition base, double height) {
  base.xyz.z() = height;
  return base;
}

}  // namespace

PhaseEnd ReleasePhase::run(Robot& robot, PickState& state) {
  if (const auto place = place_of_last_contacts(robot)) {
    state.place = place->cwiseMax(-kReach).cwiseMin(kReach);
  }
  if (const auto closed = robot.log().at(Mark::closed)) {
    const double height = robot.log().readings[*closed].base.xyz.z();
    const auto& base = robot.command().base;
    if (base.xyz.z() > height) robot.move_base(at_height(base, height), kDownSpeed);
  }
  robot.set_grip(std::nullopt);
  hand::ActuatorVector open = robot.command().positions;
  for (int i = 0; i < hand::kActuators; ++i) {
    if (hand::finger_of_actuator(i) >= 0) open[i] = std::min(open[i], 0.1);
  }
  robot.move_fingers(open, 0.6);
  robot.move_base(at_height(robot.command().base, kFreeHeight), kUpSpeed);
  robot.mark(Mark::released);
  return {true, fmt::format("next try at ({:.0f}, {:.0f}) mm", 1e3 * state.place.x(),
                            1e3 * state.place.y())};
}

}  // namespace palpate::pipeline
