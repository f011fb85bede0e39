// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "palpate/hand/kinematics.hpp"
#include "palpate/tactile/contacts/contact.hpp"

namespace palpate::grasping {

/// A force from elsewhere, as the weight, that the fingertips are to bear.
struct Load {
  Eigen::Vector3d point, force;  ///< m, N
};

/// Forces of fingertips on an object that cancel as well as friction allows.
struct ForceDistribution {
  std::vector<Eigen::Vector3d> forces;  ///< one a contact, N; their pressing parts sum to `total`
  double wrench_residual = 0;  ///< length of the net wrench over `total`; moments count per 30 mm
};

/// Least net wrench over the friction cones (four edges each) of contacts that press with `total`
/// (N) altogether, with a slight preference for forces that are shared evenly.
/// Without contacts the wrench residual is infinite.
///
/// @param contacts  in any one frame; the forces and the load are in the same
/// @param friction  coefficient, of all contacts
ForceDistribution distribute_forces(std::span<const tactile::Contact> contacts, double friction,
                                    double total, const std::optional<Load>& load = {});

/// Torques of the actuators that make the fingertips press on the object with the given forces:
/// tau = sum J' f (grasp statics); a coupled pair gets the mean of its two joints' torques.
///
/// @param contacts  in the mount's frame, each with its finger
/// @param forces  one a contact, N, of the finger on the object, mount's axes
hand::ActuatorVector pressing_torques(const hand::Description& hand,
                                      const hand::JointVector& joints,
                                      std::span<const tactile::Contact> contacts,
                                      std::span<const Eigen::Vector3d> forces);

}  // namespace palpate::grasping
