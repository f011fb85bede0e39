// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "palpate/geometry/objects/known_object.hpp"
#include "palpate/hand/hand.hpp"
#include "palpate/hand/kinematics.hpp"

namespace palpate::estimation {

/// Where an object may lie on the table.
struct PlaceOnTable {
  Eigen::Vector2d middle = Eigen::Vector2d::Zero();  ///< m
  double half_width = 0;                             ///< its center is within +- of it, m
};

/// Heights above the table, m, in which an object in a stable pose stops the lowest part of a hand
/// that comes down on it as it is in a reading: one for each of some places and directions spread
/// over all that are possible. 0 where the hand comes down beside the object. A hand is open
/// between its fingers, so that its lowest part may stop far below the object's top.
///
/// @param model  its spheres stand for the hand
/// @param above  the hand, at any height
std::vector<double> stopping_heights(const geometry::KnownObject& object,
                                     const geometry::StablePose& stable_pose,
                                     const hand::Description& model, const hand::HandReading& above,
                                     const PlaceOnTable& place);

/// The same, m, for an object whose pose is known.
double stopping_height(const geometry::KnownObject& object, const Eigen::Isometry3d& T_world_object,
                       const hand::Description& model, const hand::HandReading& above);

/// Likelihood of the height in which a hand was stopped, up to a factor, for each of the object's
/// stable poses.
///
/// @param stopped  the hand, borne by the object
/// @param sigma    m, error of its height
std::vector<double> probed_height_likelihoods(const geometry::KnownObject& object,
                                              const hand::Description& model,
                                              const hand::HandReading& stopped,
                                              const PlaceOnTable& place, double sigma);

}  // namespace palpate::estimation
