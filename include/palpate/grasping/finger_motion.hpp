// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>

#include "palpate/hand/hand.hpp"
#include "palpate/hand/kinematics.hpp"
#include "palpate/tactile/contacts/contact.hpp"

namespace palpate::grasping {

/// A small motion of an object held by fingertips.
struct GraspMotion {
  Vector6d twist = Vector6d::Zero();  ///< [w; v] at `center`, rad and m, mount's axes
  hand::PerFinger<double> press{};    ///< m by which each fingertip goes into the object
};

/// By how much the actuators move so that fingertips which stick to the object carry it along:
/// the contacts' motion is nu_c = G' nu (thesis eq 4.7), and that of each finger's joints the
/// damped least-squares solution of J q_dot = nu_c (eq 4.9). Fingers without contact stay.
///
/// @param contacts  in the mount's frame, each with its finger
/// @param center  where the twist is taken, mount's frame, m
/// @return rad; of the coupled pairs the sum of both joints
hand::ActuatorVector finger_motion(const hand::Description& hand, const hand::JointVector& joints,
                                   std::span<const tactile::Contact> contacts,
                                   const Eigen::Vector3d& center, const GraspMotion& motion);

}  // namespace palpate::grasping
