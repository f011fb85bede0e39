// SPDX-License-Identifier: Apache-2.0
#include "palpate/planning/trajectory.hpp"

namespace palpate::planning {
namespace {

Coordinates by_part(double slide, double turn, double joint, Eigen::Index size) {
  Coordinates values(size);
  values.head<3>().setConstant(slide);
  values.segment<3>(3).setConstant(turn);
  values.tail(size - kMountCoordinates).setConstant(joint);
  return values;
}

}  // namespace

Coordinates coordinates_of(const hand::HandCommand& command) {
  Coordinates coordinates(kMountCoordinates + command.positions.size());
  coordinates << command.mount.xyz, command.mount.ypr, command.positions;
  return coordinates;
}

hand::HandCommand command_of(const Coordinates& coordinates) {
  return {.positions = coordinates.tail(coordinates.size() - kMountCoordinates),
          .mount = {.xyz = coordinates.head<3>(), .ypr = coordinates.segment<3>(3)}};
}

Coordinates speed_limits(const MotionLimits& limits, Eigen::Index size) {
  return by_part(limits.mount_speed, limits.turn_speed, limits.joint_speed, size);
}

Coordinates acceleration_limits(const MotionLimits& limits, Eigen::Index size) {
  return by_part(limits.mount_acceleration, limits.turn_acceleration, limits.joint_acceleration,
                 size);
}

Coordinates metric(const hand::Description& hand) {
  constexpr double kMountLever = 0.25;  // m, from the mount's axes to fingertips and forearm
  Coordinates values = by_part(1, kMountLever, 0, kMountCoordinates + hand.actuator_count());
  for (int i = 0; i < hand.actuator_count(); ++i) {
    values[kMountCoordinates + i] = hand.actuators[static_cast<std::size_t>(i)].lever;
  }
  return values;
}

double distance(const Coordinates& a, const Coordinates& b, const Coordinates& metric) {
  return (b - a).cwiseProduct(metric).norm();
}

}  // namespace palpate::planning
