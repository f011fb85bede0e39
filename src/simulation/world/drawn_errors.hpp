// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "palpate/core/random.hpp"
#include "palpate/geometry/objects/known_object.hpp"
#include "palpate/hand/description.hpp"
#include "palpate/simulation/world/world.hpp"

namespace palpate::simulation {

/// An object as it is, and its convex parts.
struct SolidObject {
  geometry::KnownObject object;
  std::vector<geometry::TriangleMesh> parts;
};

/// The object as it was given.
SolidObject believed_object(const geometry::KnownObject& known);

/// A believed object as it is: of another size, dented, of another mass. Its frame, stable poses
/// and symmetries stay those that were given.
SolidObject differing_object(SolidObject solid, const WorldErrors& error,
                             const RandomStream& random);

/// The options with frictions drawn.
WorldOptions with_drawn_friction(WorldOptions options, const RandomStream& random);

/// Attitude of the table.
Eigen::Matrix3d drawn_tilt(const WorldErrors& error, const RandomStream& random);

/// The hand as the robot is given it: its links are off, and so is where the arm carries it.
hand::Description believed_hand(hand::Description hand, const WorldOptions& options,
                                const RandomStream& random);

}  // namespace palpate::simulation
