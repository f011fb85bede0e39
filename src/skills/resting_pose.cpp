// SPDX-License-Identifier: Apache-2.0
#include "palpate/skills/resting_pose.hpp"

namespace palpate::skills {

Eigen::Isometry3d resting_pose(const geometry::KnownObject& object, std::size_t stable_pose,
                               const Eigen::Vector2d& xy, double yaw) {
  const geometry::StablePose& rest = object.stable_poses[stable_pose];
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.linear() = Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ()) * rest.R_table_object;
  T.translation() << xy, rest.height;
  return T;
}

}  // namespace palpate::skills
