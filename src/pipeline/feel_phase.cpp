// SPDX-License-Identifier: Apache-2.0
#include "palpate/pipeline/feel_phase.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <limits>

namespace palpate::pipeline {
namespace {

constexpr double kRetreat = 0.06;  // m, up from the touch

// With the forearm raised, these angles of wrist and knuckles make the underside of the fingers and
// of the palm's front one level plane; kLevelCenter is its middle, seen from the base.
constexpr double kForearmPitch = 0.5;               // rad
constexpr double kWristBend = -0.25;                // rad
constexpr double kKnuckleBend = -0.25;              // rad
const Eigen::Vector2d kLevelCenter(0.072, -0.005);  // m

/// Where to feel for the object, as shares of the search's width from its rough place.
const std::array<Eigen::Vector2d, 5> kSearch = {
    Eigen::Vector2d{0, 0}, {1, 0}, {0, 1}, {-1, 0}, {0, -1}};

hand::ActuatorVector flat_hand() {
  hand::ActuatorVector posture = hand::ActuatorVector::Zero();
  posture[hand::actuator_index("WRJ1")] = kWristBend;
  posture[hand::actuator_index("THJ5")] = -1.0;
  posture[hand::actuator_index("THJ2")] = -0.5;
  for (const char* knuckle : {"FFJ3", "MFJ3", "RFJ3", "LFJ3"}) {
    posture[hand::actuator_index(knuckle)] = kKnuckleBend;
  }
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

Eigen::Vector2d place_under_hand(const hand::HandReading& reading) {
  return reading.base.xyz.head<2>() + Eigen::Rotation2Dd(reading.base.ypr[0]) * kLevelCenter;
}

PhaseEnd FeelPhase::run(Robot& robot, PickState& state) {
  const Eigen::Vector2d rough = state.place;
  robot.move_fingers(flat_hand(), 0.4);
  for (const auto& side : kSearch) {
    const Eigen::Vector2d place = rough + options_.search * side;
    if (!lower(robot, state, place)) continue;
    state.place = place;
    return {true, fmt::format("{:.0f} mm tall", 1e3 * state.height)};
  }
  return {false, "felt nothing above the table"};
}

/// Comes down flat over a place. @return whether there was something above the table
bool FeelPhase::lower(Robot& robot, PickState& state, const Eigen::Vector2d& place) const {
  const Eigen::Vector2d xy = place - Eigen::Rotation2Dd(state.yaw) * kLevelCenter;
  hand::BasePosition above;
  above.xyz = {xy.x(), xy.y(), options_.start_height};
  above.ypr = {state.yaw, kForearmPitch, 0};
  robot.move_base(above, options_.travel_speed);
  robot.wait(0.2);

  hand::BasePosition low = above;
  low.xyz.z() = -options_.start_height;
  const auto touched = lasting_load(robot, -Eigen::Vector3d::UnitZ(), options_.touch_force);
  bool found = false;
  robot.move_base(low, options_.speed, [&](const hand::HandReading& reading) {
    found = touched(reading);
    return found || lowest_of_hand(robot.model(), reading) < options_.clearance;
  });
  if (found) {
    robot.mark(Mark::felt);
    state.height = lowest_of_hand(robot.model(), robot.reading());
  }
  hand::BasePosition up = robot.command().base;
  up.xyz.z() += kRetreat;
  robot.move_base(up, options_.travel_speed);
  return found;
}

}  // namespace palpate::pipeline
