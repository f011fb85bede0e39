// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Geometry>

namespace palpate::localization {

/// Pose of the object in the evidence's frame, in single precision: the search evaluates millions.
struct SearchPose {
  Eigen::Matrix3f R = Eigen::Matrix3f::Identity();
  Eigen::Vector3f t = Eigen::Vector3f::Zero();

  /// The pose turned by `turn` about the point `center` (both in the evidence's frame).
  SearchPose turned(const Eigen::Matrix3f& turn, const Eigen::Vector3f& center) const {
    return {turn * R, turn * (t - center) + center};
  }
};

/// Rotation by |w| rad about w.
inline Eigen::Matrix3f turn_by(const Eigen::Vector3f& w) {
  const float angle = w.norm();
  if (angle < 1e-9F) return Eigen::Matrix3f::Identity();
  return Eigen::AngleAxisf(angle, w / angle).toRotationMatrix();
}

}  // namespace palpate::localization
