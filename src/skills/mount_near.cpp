// SPDX-License-Identifier: Apache-2.0
#include "skills/mount_near.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

#include "palpate/core/angle.hpp"

namespace palpate::skills {
namespace {

/// Angles of Rz Ry Rx. There are two triples; the second one turns pitch past the vertical.
std::array<Eigen::Vector3d, 2> angles_of(const Eigen::Matrix3d& R) {
  const double pitch = std::asin(std::clamp(-R(2, 0), -1.0, 1.0));
  const double yaw = std::atan2(R(1, 0), R(0, 0));
  const double roll = std::atan2(R(2, 1), R(2, 2));
  return {Eigen::Vector3d(yaw, pitch, roll), {yaw + kPi, kPi - pitch, roll + kPi}};
}

}  // namespace

hand::MountPosition mount_near(const Eigen::Isometry3d& T_world_mount,
                               const hand::MountPosition& near) {
  constexpr double kTurn = 2 * std::numbers::pi;
  hand::MountPosition best;
  best.xyz = T_world_mount.translation();
  double least = std::numeric_limits<double>::infinity();
  for (Eigen::Vector3d ypr : angles_of(T_world_mount.linear())) {
    ypr -= kTurn * ((ypr - near.ypr) / kTurn).array().round().matrix();
    const double turn = (ypr - near.ypr).norm();
    if (turn >= least) continue;
    least = turn;
    best.ypr = ypr;
  }
  return best;
}

}  // namespace palpate::skills
