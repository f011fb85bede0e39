// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>

#include "palpate/geometry/mesh/mesh.hpp"

namespace palpate::geometry {

/// A solid: negative inside, positive outside, near the surface about the distance to it, m.
using Solid = std::function<double(const Eigen::Vector3d&)>;

/// The solid's surface by marching tetrahedra (Doi & Koide 1991) on cubes of the given edge that
/// are split into six tetrahedra each. It is watertight: what reaches the box's border is closed
/// there.
/// @param cell  edge of the cubes, m
/// @throws BadInput unless cell and the box's sizes are positive and finite
TriangleMesh extract_surface(const Solid& solid, const Eigen::AlignedBox3d& box, double cell);

}  // namespace palpate::geometry
