// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "palpate/core/random.hpp"
#include "palpate/hand/description.hpp"

namespace palpate::hand {

/// Geometric Jacobian [w; v], one column a joint.
using Jacobian = Eigen::Matrix<double, 6, Eigen::Dynamic, 0, 6, kMaxJoints>;

/// T_mount_link of every link at the given joint angles.
std::vector<Eigen::Isometry3d> forward_kinematics(const Description& hand,
                                                  const JointVector& joints);

/// Geometric Jacobian [w; v] of a point fixed to a link, in the mount's axes.
/// @param p_link  the point in the link's frame, m
Jacobian jacobian(const Description& hand, const JointVector& joints, int link,
                  const Eigen::Vector3d& p_link);

/// True of the links whose place in a real hand differs from the model: those that a joint moves,
/// but only one of the two that share their place in a universal joint.
bool may_be_misplaced(const Link& link);

/// Those of the links from this one to the mount that may be: indices into Description::links.
std::vector<int> misplaced_links(const Description& hand, int link);

/// The same hand with every such link displaced from where the model says, by a normal vector of
/// root mean square length `rms` (m), which becomes its kinematic_error: how far a real hand is
/// from its drawing.
Description with_perturbed_links(Description hand, double rms, RandomStream& random);

/// Positions of the actuators at the given joint angles, rad.
ActuatorVector actuator_positions(const Description& hand, const JointVector& joints);

/// Joint angles of a hand that touches nothing, the inverse of actuator_positions().
JointVector joints_in_free_flexion(const Description& hand, const ActuatorVector& positions);

struct CoupledAngles {
  double j1, j2;  ///< rad
};

/// How a coupled pair shares J0 = J1 + J2 (rad) where nothing touches the finger: J2 alone up to
/// the angle from which it draws J1 along, then both alike until J2 is at its end.
CoupledAngles share_in_free_flexion(double j0, const Coupling& coupling);

/// The J0 at which J2 has the given angle (rad) in free flexion, J1 as share_in_free_flexion()
/// says.
double j0_for_middle(double j2, const Coupling& coupling);

}  // namespace palpate::hand
