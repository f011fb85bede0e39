// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

namespace palpate::tactile {

/// A contact with the object as the estimators use it, with its uncertainty.
struct Contact {
  int finger = -1;    ///< index into hand::Description::fingers; -1 unknown
  double time = 0;    ///< s
  Eigen::Vector3d p;  ///< point, m
  /// Outward unit normal of the object; zero where the sensor measures none.
  Eigen::Vector3d n = Eigen::Vector3d::Zero();
  Eigen::Vector3d f = Eigen::Vector3d::Zero();  ///< force of the finger on the object, N
  double point_sigma = 0.001;                   ///< per axis, m
  double normal_sigma = 0.1745;                 ///< per tangent axis, rad; without a normal unused
  /// Contacts of one group (>= 0) are candidates of which at least one touches; -1: it touches.
  int group = -1;

  [[nodiscard]] bool has_normal() const { return !n.isZero(0); }
};

}  // namespace palpate::tactile
