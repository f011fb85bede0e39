// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Geometry>
#include <optional>

#include "palpate/tactile/contacts/contact.hpp"

namespace palpate::tactile {

/// A fingertip of known shape on a force-torque sensor: a capsule about the segment from `a` to
/// `b`, in the sensor's frame; a ball where they are equal.
struct FingertipCapsule {
  Eigen::Vector3d a, b;  ///< m
  double radius = 0;     ///< m
};

/// What the sensor measures of the object's contact with the fingertip, about the origin of its
/// frame.
struct ContactWrench {
  Eigen::Vector3d f;  ///< force of the object on the finger, N
  Eigen::Vector3d m;  ///< moment, N m
};

struct IntrinsicOptions {
  double min_force = 0.1;       ///< N below which there is no contact
  double force_sigma = 0.02;    ///< N, per axis
  double moment_sigma = 0.001;  ///< N m, per axis
};

/// The one contact that explains a wrench: where its axis enters the fingertip, the force pressing
/// it in (Bicchi, Salisbury & Brock, "Contact sensing from force measurements", IJRR 12(3), 1993,
/// wrench-axis method; exact for a point contact with friction).
///
/// The error of the point is that of the axis, sqrt(sm^2 + |p|^2 sf^2) / |f|, over the cosine at
/// which it meets the surface; that of the normal is the point's over the radius.
/// @param T_frame_sensor  of the sensor in the frame of the contact
/// @return nothing for a force below min_force or an axis that misses the fingertip
/// @throws BadInput for values that are not finite or a radius or option that is not positive
std::optional<Contact> contact_of_wrench(const ContactWrench& wrench,
                                         const FingertipCapsule& fingertip,
                                         const Eigen::Isometry3d& T_frame_sensor,
                                         const IntrinsicOptions& options = {});

}  // namespace palpate::tactile
