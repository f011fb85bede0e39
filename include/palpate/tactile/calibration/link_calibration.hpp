// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Geometry>
#include <span>
#include <vector>

#include "palpate/hand/kinematics.hpp"

namespace palpate::tactile {

/// A posture in which it matters where a fingertip is.
struct TipPosture {
  int finger = 0;
  hand::JointVector joints;  ///< rad
};

/// A fingertip that touches a plane, such as a bare table.
struct TipOnPlane {
  TipPosture tip;
  Eigen::Vector3d p;  ///< point that touches, in the distal link's frame, m
  /// Where the plane is believed: z = 0 of this frame, z towards the hand.
  Eigen::Isometry3d T_mount_plane = Eigen::Isometry3d::Identity();
  double sigma = 0.0003;  ///< m, of that point along the normal, but for what is to be found
};

/// What is known before of how far things are from where they are believed, standard deviations of
/// each component.
struct MountPrior {
  double mount = 0;         ///< m, of the hand on what carries it
  double mount_angle = 0;   ///< rad
  double table_height = 0;  ///< m, of the plane, at its frame's origin
  double table_tilt = 0;    ///< rad, of the plane
};

/// The hand and the plane calibrated by touches of the plane.
struct HandCalibration {
  hand::Description hand;
  /// The plane, from where it was believed: raised, and tilted about its frame's x and y.
  Eigen::Isometry3d T_believed_plane = Eigen::Isometry3d::Identity();
};

/// The hand whose links are where touches of a plane place them, where the mount carries it, and
/// where the plane is.
///
/// Unknown are a displacement of every link that may_be_misplaced(), normal with the hand's
/// kinematic_error, and those of MountPrior; a point's distance from the plane is linear in all of
/// them. The result has their posterior means, and as kinematic_error what is left of it: that
/// which makes link_offset_sigma right, in the mean square, for the tips in `uses`.
/// @return the hand as it was, if there is no touch or no use, or nothing is unknown
/// @throws BadInput for a finger that does not exist, values that are not finite, a sigma that is
///         not positive, and a negative kinematic_error
HandCalibration calibrate_links(const hand::Description& hand, std::span<const TipOnPlane> touches,
                                std::span<const TipPosture> uses, const MountPrior& prior = {});

/// How far the touching point is from the plane as both are believed, m.
/// @throws BadInput as calibrate_links
double distance_from_plane(const hand::Description& hand, const TipOnPlane& touch);

/// The touches, one after the other, that lessen the variance of the tips in `uses` most (greedy
/// A-optimal design); it does not depend on what they find.
/// @return `count` indices of candidates, fewer if there are not so many; each once
/// @throws BadInput as calibrate_links
std::vector<std::size_t> choose_touches(const hand::Description& hand,
                                        std::span<const TipOnPlane> candidates, std::size_t count,
                                        std::span<const TipPosture> uses,
                                        const MountPrior& prior = {});

}  // namespace palpate::tactile
