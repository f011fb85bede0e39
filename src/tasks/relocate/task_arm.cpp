// SPDX-License-Identifier: Apache-2.0
#include "tasks/relocate/task_arm.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "simulation/hand/hand_model.hpp"
#include "simulation/hand/hand_spec.hpp"
#include "tasks/relocate/relocate_model.hpp"

namespace palpate::relocate {

Eigen::Vector3d xyz_angles(const Eigen::Matrix3d& R) {
  return {std::atan2(-R(1, 2), R(2, 2)), std::asin(std::clamp(R(0, 2), -1.0, 1.0)),
          std::atan2(-R(0, 1), R(0, 0))};
}

TaskArm::TaskArm(const RelocateModel& model) : model_(model) {
  const mjModel& compiled = *model.impl().scene.model;
  const int forearm = simulation::find_id(compiled, mjOBJ_BODY, "forearm");
  T_world_rest_ =
      simulation::pose3(compiled.body_pos + 3 * forearm, compiled.body_quat + 4 * forearm);
}

hand::MountPosition TaskArm::mount(const RelocateJoints& q) const {
  const Eigen::Isometry3d T_world_forearm = T_world_rest_ * Eigen::Translation3d(q.head<3>()) *
                                            Eigen::AngleAxisd(q[3], Eigen::Vector3d::UnitX()) *
                                            Eigen::AngleAxisd(q[4], Eigen::Vector3d::UnitY()) *
                                            Eigen::AngleAxisd(q[5], Eigen::Vector3d::UnitZ());
  Eigen::Isometry3d T_world_mount = T_world_forearm;
  T_world_mount.linear() = T_world_forearm.linear() * R_mount_forearm().transpose();
  return hand::MountPosition::at(T_world_mount);
}

Vector6d TaskArm::joints(const hand::MountPosition& mount) const {
  Eigen::Isometry3d T_world_forearm = mount.pose();
  T_world_forearm.linear() = T_world_forearm.linear() * R_mount_forearm();
  const Eigen::Isometry3d T_rest_forearm = T_world_rest_.inverse() * T_world_forearm;
  Vector6d result;
  result << T_rest_forearm.translation(), xyz_angles(T_rest_forearm.linear());
  return result;
}

std::string TaskArm::obstacle(const Vector6d& joints) const {
  constexpr double kRounding = 1e-6;  // m, rad
  const mjModel& model = *model_.impl().scene.model;
  for (int i = 0; i < kArmJoints; ++i) {
    const mjtNum low = model.jnt_range[2 * i], high = model.jnt_range[2 * i + 1];
    if (joints[i] >= low - kRounding && joints[i] <= high + kRounding) continue;
    return fmt::format("{} would be at {:.5g} {}, its range is {:.5g} to {:.5g}",
                       mj_id2name(&model, mjOBJ_JOINT, i), joints[i], i < 3 ? "m" : "rad", low,
                       high);
  }
  return {};
}

}  // namespace palpate::relocate
