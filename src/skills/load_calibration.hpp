// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Dense>

#include "palpate/skills/load_sensor.hpp"

namespace palpate::skills {

/// Finds what the mount's load reads where nothing but the hand hangs on it: a constant force in
/// the mount's frame (the sensor's bias) and one along the vertical (weight of the hand that is
/// taken off it wrongly). Least squares over attitudes, with a little damping.
class LoadCalibration {
 public:
  /// @param load  of a hand that stands free, N
  void add(const hand::MountPosition& mount, const Eigen::Vector3d& load);

  /// @return no error before add()
  [[nodiscard]] LoadError error() const;

 private:
  Eigen::Matrix4d information_ = Eigen::Matrix4d::Zero();
  Eigen::Vector4d weighted_ = Eigen::Vector4d::Zero();
};

}  // namespace palpate::skills
