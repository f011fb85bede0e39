// SPDX-License-Identifier: Apache-2.0
#include "palpate/planning/trajectory.hpp"

namespace palpate::planning {
namespace {

Coordinates by_part(double slide, double turn, double joint, Eigen::Index size) {
  Coordinates values(size);
  values.head<3>().setConstant(slide);
  values.segment<3>(3).setConstant(turn);
  values.tail(size - kBaseCoordinates).setConstant(joint);
  return values;
}

}  // namespace

Coordinates coordinates_of(const hand::HandCommand& command) {
  Coordinates coordinates(kBaseCoordinates + command.positions.size());
  coordinates << command.base.xyz, command.base.ypr, command.positions;
  return coordinates;
}

hand::HandCommand command_of(const Coordinates& coordinates) {
  return {.positions = coordinates.tail(coordinates.size() - kBaseCoordinates),
          .base = {.xyz = coordinates.head<3>(), .ypr = coordinates.segment<3>(3)}};
}

Coordinates speed_limits(const MotionLimits& limits, Eigen::Index size) {
  return by_part(limits.base_speed, limits.turn_speed, limits.joint_speed, size);
}

Coordinates acceleration_limits(const MotionLimits& limits, Eigen::Index size) {
  return by_part(limits.base_acceleration, limits.turn_acceleration, limits.joint_acceleration,
                 size);
}

Coordinates metric(const hand::Description& hand) {
  constexpr double kBaseLever = 0.25;  // m, from the base's axes to fingertips and forearm
  Coordinates values = by_part(1, kBaseLever, 0, kBaseCoordinates + hand.actuator_count());
  for (int i = 0; i < hand.actuator_count(); ++i) {
    values[kBaseCoordinates + i] = hand.actuators[static_cast<std::size_t>(i)].lever;
  }
  return values;
}

double distance(const Coordinates& a, const Coordinates& b, const Coordinates& metric) {
  return (b - a).cwiseProduct(metric).norm();
}

}  // namespace palpate::planning
