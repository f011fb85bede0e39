// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <vector>

#include "palpate/geometry/mesh/mesh.hpp"

namespace palpate::geometry {

/// Straight piece of a hull facet's border, counter-clockwise seen from outside.
struct HullEdge {
  Eigen::Vector3d from, to;
  int neighbour = -1;  ///< facet on its other side
};

/// Flat part of a convex hull's surface.
struct HullFacet {
  Eigen::Vector3d normal;                                 ///< outward, unit
  std::vector<std::array<Eigen::Vector3d, 3>> triangles;  ///< counter-clockwise seen from outside
  std::vector<HullEdge> border;
};

/// Convex hull of points, triangles within `flat` rad of a larger one's plane joined with it.
///
/// Quickhull (Barber, Dobkin & Huhdanpaa 1996).
/// @throws BadInput if the points span no volume
std::vector<HullFacet> convex_hull(const std::vector<Eigen::Vector3d>& points, double flat = 2e-3);

/// Corners of the convex hull of points. @throws BadInput if they span no volume
std::vector<Eigen::Vector3d> hull_corners(const std::vector<Eigen::Vector3d>& points);

}  // namespace palpate::geometry
