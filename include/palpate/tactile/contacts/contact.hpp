// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

namespace palpate::tactile {

/// A contact with the object as the estimators use it, with its uncertainty.
struct Contact {
  int finger = -1;    ///< index into hand::Description::fingers; -1 unknown
  double time = 0;    ///< s
  Eigen::Vector3d p;  ///< point, m
  Eigen::Vector3d n;  ///< outward unit normal of the object
  Eigen::Vector3d f = Eigen::Vector3d::Zero();  ///< force of the finger on the object, N
  double point_sigma = 0.001;                   ///< per axis, m
  double normal_sigma = 0.1745;                 ///< per tangent axis, rad
};

}  // namespace palpate::tactile
