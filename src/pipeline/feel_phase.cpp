// SPDX-License-Identifier: Apache-2.0
#include "palpate/pipeline/feel_phase.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <limits>

namespace palpate::pipeline {
namespace {

constexpr double kRetreat = 0.06;  // m, up from the touch

/// All fingers straight, the thumb aside, the wrist bent so that the palm is level.
hand::ActuatorVector flat_hand(double pitch) {
  hand::ActuatorVector posture = hand::ActuatorVector::Zero();
  posture[hand::actuator_index("WRJ1")] = -pitch;
  posture[hand::actuator_index("THJ5")] = -0.9;
  return posture;
}

}  // namespace

double lowest_of_hand(const hand::HandModel& model, const hand::HandReading& reading) {
  const auto T_base_link = hand::forward_kinematics(model, reading.joints);
  const Eigen::Isometry3d T_world_base = reading.base.pose();
  double lowest = std::numeric_limits<double>::infinity();
  for (const auto& sphere : model.spheres) {
    const Eigen::Vector3d center =
        T_world_base * T_base_link[static_cast<std::size_t>(sphere.link)] * sphere.center;
    lowest = std::min(lowest, center.z() - sphere.radius);
  }
  return lowest;
}

PhaseEnd FeelPhase::run(Robot& robot, PickState& state) {
  hand::BasePosition above;
  above.xyz = {state.place.x(), state.place.y(), options_.start_height};
  above.ypr = {state.yaw, options_.pitch, 0};
  robot.move_fingers(flat_hand(options_.pitch), 0.4);
  robot.move_base(above, options_.travel_speed);
  robot.wait(0.2);

  hand::BasePosition low = above;
  low.xyz.z() = 0;
  const auto touched = [&](const hand::HandReading& reading) {
    return reading.base_force.z() < -options_.touch_force;
  };
  const auto stop = [&](const hand::HandReading& reading) {
    return touched(reading) || lowest_of_hand(robot.model(), reading) < options_.clearance;
  };
  robot.move_base(low, options_.speed, stop);
  const bool found = touched(robot.reading());
  if (found) {
    robot.mark(Mark::felt);
    state.height = lowest_of_hand(robot.model(), robot.reading());
  }
  hand::BasePosition up = robot.command().base;
  up.xyz.z() += kRetreat;
  robot.move_base(up, options_.travel_speed);
  if (!found) return {false, "felt nothing above the table"};
  return {true, fmt::format("{:.0f} mm tall", 1e3 * state.height)};
}

}  // namespace palpate::pipeline
