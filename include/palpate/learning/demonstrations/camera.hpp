// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Geometry>

namespace palpate::learning {

/// A pinhole camera that looks along +z, x to the right, y down.
struct PinholeCamera {
  double focal = 600;                   ///< pixels
  Eigen::Vector2d center = {320, 240};  ///< pixels; of the middle of pixel (0, 0) is (0, 0)
  int width = 640, height = 480;        ///< pixels

  /// Pixel of a point (m, camera's frame; z > 0).
  Eigen::Vector2d project(const Eigen::Vector3d& p) const {
    return focal * p.head<2>() / p.z() + center;
  }

  /// Direction of a pixel, with z = 1.
  Eigen::Vector3d ray(const Eigen::Vector2d& pixel) const {
    return ((pixel - center) / focal).homogeneous();
  }
};

}  // namespace palpate::learning
