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

/// A fingertip that feels a known plane, such as a bare table.
struct TipOnPlane {
  TipPosture tip;
  Eigen::Vector3d p;                   ///< point that touches, in the distal link's frame, m
  Eigen::Hyperplane<double, 3> plane;  ///< in the base's frame, normal towards the hand, m
  double sigma = 0.0003;               ///< m, of that point along the normal, but for the links
};

/// The hand whose links are where touches of planes tell that they are.
///
/// Every link that may_be_misplaced() has an unknown displacement, normal with the hand's
/// kinematic_error; a point's distance from its plane is linear in those of its finger. The result
/// has their posterior means, and as kinematic_error what is left of it: that which makes
/// link_offset_sigma right, in the mean square, for the tips in `uses`.
/// @return the hand as it was, if there is no touch or no use, or it is known without error
/// @throws BadInput for a finger that does not exist, values that are not finite, a sigma that is
///         not positive, and a negative kinematic_error
hand::Description calibrate_links(const hand::Description& hand,
                                  std::span<const TipOnPlane> touches,
                                  std::span<const TipPosture> uses);

/// How far the touching point is from the plane by the hand's model, m.
/// @throws BadInput as calibrate_links
double distance_from_plane(const hand::Description& hand, const TipOnPlane& touch);

/// The touches, one after the other, that lessen the variance of the tips in `uses` most (greedy
/// A-optimal design); it does not depend on what they find.
/// @return `count` indices of candidates, fewer if there are not so many; each once
/// @throws BadInput as calibrate_links
std::vector<std::size_t> choose_touches(const hand::Description& hand,
                                        std::span<const TipOnPlane> candidates, std::size_t count,
                                        std::span<const TipPosture> uses);

}  // namespace palpate::tactile
