// SPDX-License-Identifier: Apache-2.0
#include "palpate/tasks/relocate/drawn_task.hpp"

#include "palpate/core/assets.hpp"
#include "palpate/hand/kinematics.hpp"
#include "palpate/simulation/hand/load_hand.hpp"
#include "palpate/tasks/relocate/relocate_touch.hpp"
#include "tasks/relocate/relocated_object.hpp"

namespace palpate::relocate {
namespace {

constexpr double kTargetOpacity = 0.35;

geometry::KnownObject drawn_object(const RelocateObject& object, double mass) {
  geometry::KnownObject drawn;
  drawn.name = object.name;
  drawn.mesh = surface(object);
  drawn.mass = mass;
  drawn.symmetries = {Eigen::Matrix3d::Identity()};
  return drawn;
}

}  // namespace

DrawnTask::DrawnTask(const TaskOptions& task, const RelocateModel& model)
    : dynamics_(model),
      hand_(simulation::load_shadow_hand(asset("shadow_hand/right_hand.xml"))),
      object_(drawn_object(make_object(task), model.object_mass())) {}

simulation::DrawnState DrawnTask::at(const Eigen::VectorXd& positions) {
  const RelocateJoints q = positions.head<kRelocateJoints>();
  const hand::JointVector joints = shadow_joints(q);
  const auto links = hand::forward_kinematics(hand_, joints);
  const auto& T_mount_palm = links[static_cast<std::size_t>(hand_.palm)];
  return {object_pose(positions), joints,
          hand::MountPosition::at(dynamics_.palm(q) * T_mount_palm.inverse())};
}

simulation::DrawnState DrawnTask::at(const Eigen::VectorXd& positions,
                                     const Eigen::Vector3d& target) {
  simulation::DrawnState state = at(positions);
  Eigen::Isometry3d T_world_target = state.T_world_object;
  T_world_target.translation() = target;
  state.ghosts.push_back({T_world_target, kTargetOpacity});
  return state;
}

simulation::Camera task_camera() {
  return {.lookat = {0, -0.1, 0.18}, .distance = 1.25, .azimuth_deg = 40, .elevation_deg = -20};
}

}  // namespace palpate::relocate
