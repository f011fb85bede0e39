// SPDX-License-Identifier: Apache-2.0
#include "palpate/hand/nearest_mount.hpp"

#include <cmath>
#include <numbers>

namespace palpate::hand {
namespace {

constexpr double kWholeTurn = 2 * std::numbers::pi;
constexpr double kQuarterTurn = 1e-6;  // rad from a pitch of a quarter turn

Eigen::Vector3d unwrapped(Eigen::Vector3d ypr, const Eigen::Vector3d& near) {
  for (int i = 0; i < 3; ++i) ypr[i] += kWholeTurn * std::round((near[i] - ypr[i]) / kWholeTurn);
  return ypr;
}

/// Only yaw - roll (pitch up) or yaw + roll (down) is known.
Eigen::Vector3d at_quarter_turn(const Eigen::Matrix3d& R, const Eigen::Vector3d& near) {
  const double sign = R(2, 0) < 0 ? 1 : -1;
  const double known = std::atan2(-R(0, 1), R(1, 1));
  const double half = std::remainder(known - (near[0] - sign * near[2]), kWholeTurn) / 2;
  const double pitch = sign * kWholeTurn / 4;
  return {near[0] + half, pitch + kWholeTurn * std::round((near[1] - pitch) / kWholeTurn),
          near[2] - sign * half};
}

}  // namespace

MountPosition nearest_mount(const Eigen::Isometry3d& T_world_mount, const MountPosition& near) {
  MountPosition found = MountPosition::at(T_world_mount);
  if (std::numbers::pi / 2 - std::abs(found.ypr[1]) < kQuarterTurn) {
    found.ypr = at_quarter_turn(T_world_mount.linear(), near.ypr);
    return found;
  }
  const double half = std::numbers::pi;
  const Eigen::Vector3d one = unwrapped(found.ypr, near.ypr);
  const Eigen::Vector3d other =
      unwrapped({found.ypr[0] + half, half - found.ypr[1], found.ypr[2] + half}, near.ypr);
  found.ypr = (one - near.ypr).norm() <= (other - near.ypr).norm() ? one : other;
  return found;
}

}  // namespace palpate::hand
