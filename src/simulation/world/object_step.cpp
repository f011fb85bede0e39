// SPDX-License-Identifier: Apache-2.0
#include "simulation/world/object_step.hpp"

#include <algorithm>
#include <array>
#include <optional>

namespace palpate::simulation {
namespace {

constexpr int kFrictionless = 1, kHard = 3, kSoft = 4;  // the solver's contact dimensions

grasping::ContactModel model_of(int dimensions) {
  if (dimensions == kFrictionless) return grasping::ContactModel::frictionless;
  return dimensions == kHard ? grasping::ContactModel::hard_finger
                             : grasping::ContactModel::soft_finger;
}

/// Of a fingertip that is one.
geometry::Capsule capsule_of(const Scene& scene, const mjData& data, int geom) {
  const mjModel& m = *scene.model;
  if (m.geom_type[geom] != mjGEOM_CAPSULE) return {};
  const Eigen::Vector3d half =
      rotation3(data.geom_xmat + 9 * geom).col(2) * m.geom_size[3 * geom + 1];
  const Eigen::Vector3d center = vector3(data.geom_xpos + 3 * geom);
  return {center - half, center + half, m.geom_size[3 * geom]};
}

/// The contact as one on the object; none if the object is not part of it.
std::optional<ObjectContact> read_contact(const Scene& scene, const mjData& data, int index) {
  const mjModel& m = *scene.model;
  const mjContact& contact = data.contact[index];
  const auto is_object = [&](int geom) { return m.geom_bodyid[geom] == scene.object; };
  if (is_object(contact.geom[0]) == is_object(contact.geom[1])) return std::nullopt;
  // The solver's normal and force point from the first to the second.
  const bool second = is_object(contact.geom[1]);
  const int other = contact.geom[second ? 0 : 1];
  const Eigen::Vector3d turn = second ? Eigen::Vector3d(1, 1, 1) : Eigen::Vector3d(-1, -1, 1);
  ObjectContact result;
  result.link = scene.links[static_cast<std::size_t>(m.geom_bodyid[other])];
  const auto tip = std::find(scene.tips.begin(), scene.tips.end(), other);
  if (tip != scene.tips.end()) {
    result.finger = static_cast<int>(tip - scene.tips.begin());
    result.capsule = capsule_of(scene, data, other);
  }
  result.T_world_contact.linear() =
      rotation3(contact.frame).transpose() * turn.asDiagonal();  // {n, t, o} towards the object
  result.T_world_contact.translation() = vector3(contact.pos);
  result.distance = contact.dist;
  std::array<mjtNum, 6> wrench{};  // force, torque
  mj_contactForce(&m, &data, index, wrench.data());
  // On the first thing the force is the opposite one; its axes n and t are turned round too.
  const Eigen::Vector3d sign = second ? turn : Eigen::Vector3d(-turn);
  result.wrench.head<3>() = sign.cwiseProduct(vector3(wrench.data() + 3));
  result.wrench.tail<3>() = sign.cwiseProduct(vector3(wrench.data()));
  result.model = model_of(contact.dim);
  result.friction = {.sliding = contact.friction[0],
                     .eccentricity = contact.friction[2] / contact.friction[0]};
  return result;
}

Eigen::Vector3d object_momentum(const Scene& scene, const mjData& data) {
  const int joint = scene.model->body_jntadr[scene.object];
  const mjtNum* const twist = data.qvel + scene.model->jnt_dofadr[joint];
  // The free joint moves the body's origin; the mass moves with its centre.
  const Eigen::Matrix3d R =
      pose3(data.qpos + scene.object_position, data.qpos + scene.object_position + 3).linear();
  const Eigen::Vector3d arm = R * vector3(scene.model->body_ipos + 3 * scene.object);
  const Eigen::Vector3d spin = R * vector3(twist + 3);
  return scene.model->body_mass[scene.object] * (vector3(twist) + spin.cross(arm));
}

}  // namespace

StepStart read_step_start(const Scene& scene, const mjData& data) {
  StepStart start{.momentum = object_momentum(scene, data),
                  .joints = hand::JointVector(static_cast<int>(scene.joint_positions.size()))};
  for (std::size_t i = 0; i < scene.joint_positions.size(); ++i) {
    start.joints[static_cast<int>(i)] = data.qpos[scene.joint_positions[i]];
  }
  return start;
}

ObjectStep read_object_step(const Scene& scene, const mjData& data, const StepStart& start) {
  const mjModel& m = *scene.model;
  ObjectStep step;
  step.time = data.time - m.opt.timestep;
  // Bodies and contacts are still those of the step's start; positions and velocities are not.
  step.T_world_object = body_pose(data, scene.object);
  const Eigen::Isometry3d T_mount_root =
      pose3(m.body_pos + 3 * scene.root, m.body_quat + 4 * scene.root);
  step.T_world_mount = body_pose(data, scene.root) * T_mount_root.inverse();
  step.joints = start.joints;
  step.gravity = m.body_mass[scene.object] * vector3(m.opt.gravity);
  step.momentum_change = object_momentum(scene, data) - start.momentum;
  for (int i = 0; i < data.ncon; ++i) {
    if (const auto contact = read_contact(scene, data, i)) step.contacts.push_back(*contact);
  }
  return step;
}

}  // namespace palpate::simulation
