// SPDX-License-Identifier: Apache-2.0
#include "palpate/planning/trajectory.hpp"

namespace palpate::planning {
namespace {

/// Metres that a fingertip moves a radian of the joint, roughly its distance from the axis.
double lever(std::string_view actuator) {
  if (actuator.starts_with("WR")) return 0.18;
  if (actuator == "THJ1") return 0.035;
  if (actuator == "THJ2" || actuator == "THJ3") return 0.07;
  return actuator.back() == '0' ? 0.05 : 0.1;
}

Coordinates by_part(double slide, double turn, double joint) {
  Coordinates values;
  values.head<3>().setConstant(slide);
  values.segment<3>(3).setConstant(turn);
  values.tail<hand::kActuators>().setConstant(joint);
  return values;
}

}  // namespace

Coordinates coordinates_of(const hand::HandCommand& command) {
  Coordinates coordinates;
  coordinates << command.base.xyz, command.base.ypr, command.positions;
  return coordinates;
}

hand::HandCommand command_of(const Coordinates& coordinates) {
  return {.positions = coordinates.tail<hand::kActuators>(),
          .base = {.xyz = coordinates.head<3>(), .ypr = coordinates.segment<3>(3)}};
}

Coordinates speed_limits(const MotionLimits& limits) {
  return by_part(limits.base_speed, limits.turn_speed, limits.joint_speed);
}

Coordinates acceleration_limits(const MotionLimits& limits) {
  return by_part(limits.base_acceleration, limits.turn_acceleration, limits.joint_acceleration);
}

const Coordinates& metric() {
  static const Coordinates levers = [] {
    constexpr double kBaseLever = 0.25;  // m, from the base's axes to fingertips and forearm
    Coordinates values = by_part(1, kBaseLever, 0);
    for (int i = 0; i < hand::kActuators; ++i) {
      values[6 + i] = lever(hand::kActuatorNames[static_cast<std::size_t>(i)]);
    }
    return values;
  }();
  return levers;
}

double distance(const Coordinates& a, const Coordinates& b) {
  return (b - a).cwiseProduct(metric()).norm();
}

}  // namespace palpate::planning
