// SPDX-License-Identifier: Apache-2.0
#include "palpate/estimation/height_probe.hpp"

#include <algorithm>
#include <limits>

namespace palpate::estimation {

double lowest_of_hand(const hand::Description& model, const hand::HandReading& reading) {
  const auto T_mount_link = hand::forward_kinematics(model, reading.joints);
  const Eigen::Isometry3d T_world_mount = reading.mount.pose();
  double lowest = std::numeric_limits<double>::infinity();
  for (const auto& sphere : model.spheres) {
    const Eigen::Vector3d center =
        T_world_mount * T_mount_link[static_cast<std::size_t>(sphere.link)] * sphere.center;
    lowest = std::min(lowest, center.z() - sphere.radius);
  }
  return lowest;
}

Eigen::Vector2d place_under_hand(const hand::Description& model, const hand::HandReading& reading) {
  return reading.mount.xyz.head<2>() +
         Eigen::Rotation2Dd(reading.mount.ypr[0]) * model.postures.flat.center;
}

}  // namespace palpate::estimation
