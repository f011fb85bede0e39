// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "palpate/core/se3.hpp"
#include "palpate/grasping/contact_model.hpp"
#include "palpate/hand/hand.hpp"
#include "palpate/hand/kinematics.hpp"

namespace palpate::grasping {

/// A contact of the hand with the object.
///
/// Twists are [w; v] and wrenches [m; f], as everywhere here; the thesis stacks them the other way
/// round. Wrenches are those of the hand ON the object.
struct GraspContact {
  Eigen::Isometry3d T_mount_contact = Eigen::Isometry3d::Identity();  ///< axes n, t, o
  int link = -1;  ///< of the hand that touches; only the hand Jacobian needs it
  ContactModel model = ContactModel::soft_finger;
  Friction friction;
};
using GraspContacts = std::vector<GraspContact>;

/// Contact frame {n, t, o} at a point of the object's surface; n is the inward normal.
/// @param p_mount, n_mount  the point (m) and the OUTWARD unit normal of the object there
/// @throws BadInput for values that are not finite, or a normal that is not of unit length to 1e-3
Eigen::Isometry3d contact_frame(const Eigen::Vector3d& p_mount, const Eigen::Vector3d& n_mount);

/// The fingertip contacts of a reading.
GraspContacts grasp_contacts(const hand::Description& hand, const hand::HandReading& reading,
                             ContactModel model, const Friction& friction);

/// Grasp matrix G (6 x 6 n; thesis eq 4.6): object wrench = G w_c, contact twists of the object
/// nu_c = G' nu (eq 4.7, where the thesis has G' in both).
/// @param p_mount_object  where the object's wrench and twist are taken, m, in the mount's axes
/// @throws BadInput for a point or contact frame that is not finite
Eigen::MatrixXd grasp_matrix(const GraspContacts& contacts, const Eigen::Vector3d& p_mount_object);

/// Hand Jacobian J (6 n x joints; thesis eq 4.8), in the contact frames: contact twists of the
/// hand nu_c = J q_dot, joint torques tau = J' w_c (eq 4.9).
/// @throws BadInput if a contact names no link of the hand
Eigen::MatrixXd hand_jacobian(const hand::Description& hand, const hand::JointVector& joints,
                              const GraspContacts& contacts);

/// What all contacts transmit, H (m x 6 n): lambda = H w_c, and w_c = H' lambda.
Eigen::MatrixXd transmission(const GraspContacts& contacts);

/// Wrench [m; f] on the object that contact wrenches w_c (6 n, in their frames) make (eq 4.7).
/// @throws BadInput if the sizes do not fit (all of these)
Vector6d object_wrench(const Eigen::MatrixXd& G, const Eigen::VectorXd& contact_wrenches);

/// Twists (6 n) of the object's points at the contacts, in their frames, of its twist (eq 4.7).
Eigen::VectorXd object_contact_twists(const Eigen::MatrixXd& G, const Vector6d& twist);

/// Twists (6 n) of the hand's points at the contacts, in their frames (eq 4.9).
Eigen::VectorXd hand_contact_twists(const Eigen::MatrixXd& J, const hand::JointVector& velocities);

/// Joint torques, N m, that hold the contact wrenches w_c (6 n) on the object (eq 4.9).
hand::JointVector joint_torques(const Eigen::MatrixXd& J, const Eigen::VectorXd& contact_wrenches);

}  // namespace palpate::grasping
