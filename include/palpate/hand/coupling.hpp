// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "palpate/hand/joints.hpp"

namespace palpate::hand {

/// How J1 follows J2 in the four fingers, both of which the actuator J0 pulls with one tendon.
///
/// Thesis section 2.1: "If joint two exceeds a certain angle, it enforces joint one to flex
/// accordingly". On the real hand J1 never exceeds J2, and J2 may bend while J1 is held straight.
/// So a spring straightens J1, and one that is slack up to `follow_angle` draws it after J2.
struct Coupling {
  double follow_angle = 0.35;       ///< rad, J2 - J1 at which J2 starts to draw J1 along
  double draw_stiffness = 0.5;      ///< N m/rad, of J2 - J1 beyond that
  double return_torque = 0.02;      ///< N m, that straightens J1 at 0
  double return_stiffness = 0.005;  ///< N m/rad, of J1
  double distal_damping = 0.05;     ///< N m s/rad, of J1
  double middle_damping = 0.02;     ///< N m s/rad, of J2: in free flexion it moves first
};
inline constexpr Coupling kShadowCoupling;

struct CoupledAngles {
  double j1, j2;  ///< rad
};

/// How the pair shares J0 where nothing touches the finger: J2 alone up to `follow_angle`, then
/// both alike until J2 is at its end.
/// @param j0  J1 + J2, rad
CoupledAngles share_in_free_flexion(double j0, const Coupling& coupling = kShadowCoupling);

/// The J0 at which J2 has the given angle (rad) in free flexion, J1 as share_in_free_flexion()
/// says.
double j0_for_middle(double j2, const Coupling& coupling = kShadowCoupling);

/// Joint angles of a hand that touches nothing, the inverse of actuator_positions().
JointVector joints_in_free_flexion(const ActuatorVector& positions);

}  // namespace palpate::hand
