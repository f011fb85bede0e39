// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "palpate/geometry/mesh/mesh.hpp"

namespace palpate::geometry {

/// Mug standing on z = 0 about the z axis: radius 46 mm, height 81, wall and floor 4, rounded rim;
/// its D-shaped handle stands out 25 mm along +x and is 55 mm high. One watertight surface.
TriangleMesh mug_mesh();

/// Bottle standing on z = 0 about the z axis: an oval body 96 mm along x by 66 along y, with
/// shoulder, neck, cap and nozzle, 190 mm high.
TriangleMesh bottle_mesh();

/// Axis-aligned box centred at the origin, 12 triangles.
/// @param size  edge lengths, m
/// @throws BadInput unless all are positive and finite
TriangleMesh box_mesh(const Eigen::Vector3d& size);

/// L-shaped bracket: legs 120 mm along x and 80 along y, 20 thick, 40 wide (z); corner at the
/// origin.
TriangleMesh bracket_mesh();

/// Bath duck standing on z = 0, 99 x 66 x 83 mm, its beak towards +x: blended ellipsoids with a
/// flat bottom, the head turned to the left and the left wing lifted, so that it has no symmetry.
TriangleMesh duck_mesh();

}  // namespace palpate::geometry
