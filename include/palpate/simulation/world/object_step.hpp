// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <vector>

#include "palpate/core/se3.hpp"
#include "palpate/geometry/query/capsule_collider.hpp"
#include "palpate/grasping/contact_model.hpp"
#include "palpate/hand/description.hpp"

namespace palpate::simulation {

/// A contact of the object as the solver has it, without noise.
struct ObjectContact {
  int link = -1;    ///< of the hand (index into Description::links); -1: the table
  int finger = -1;  ///< whose fingertip capsule it is; -1: no fingertip
  Eigen::Isometry3d T_world_contact = Eigen::Isometry3d::Identity();  ///< n (into the object), t, o
  double distance = 0;                                                ///< m, negative: penetration
  Vector6d wrench = Vector6d::Zero();  ///< [m; f] on the object, in the contact's frame
  grasping::ContactModel model = grasping::ContactModel::soft_finger;
  grasping::Friction friction;
  geometry::Capsule capsule;  ///< of the fingertip, in the world; nothing without one
};

/// One step of the physics as the object undergoes it. What only the simulator knows: for judging
/// and for tests, never for estimating or acting.
struct ObjectStep {
  double time = 0;                                                   ///< s, at its start
  Eigen::Isometry3d T_world_object = Eigen::Isometry3d::Identity();  ///< at its start
  Eigen::Isometry3d T_world_mount = Eigen::Isometry3d::Identity();   ///< of the hand, at its start
  hand::JointVector joints;                                          ///< rad, at its start
  Eigen::Vector3d gravity = Eigen::Vector3d::Zero();                 ///< N, on the object
  Eigen::Vector3d momentum_change = Eigen::Vector3d::Zero();         ///< N s, linear
  std::vector<ObjectContact> contacts;
};

using StepObserver = std::function<void(const ObjectStep&)>;

}  // namespace palpate::simulation
