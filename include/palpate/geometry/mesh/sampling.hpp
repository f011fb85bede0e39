// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "palpate/core/random.hpp"
#include "palpate/geometry/mesh/mesh.hpp"

namespace palpate::geometry {

struct SurfaceSample {
  Eigen::Vector3d point;
  Eigen::Vector3d normal;  ///< of the face, unit, outward
};

/// Points spread uniformly over the area, in the order of the triangles.
///
/// The cumulated area is cut into `count` equal strata with one point each, so that any part of the
/// surface made of successive triangles gets its share of points to within two.
/// @throws BadInput for a mesh without area
std::vector<SurfaceSample> sample_surface(const TriangleMesh& mesh, std::size_t count,
                                          RandomStream random);

/// A coarser mesh for drawing: the vertices in each cube of a grid become one, their mean
/// (Rossignac & Borrel 1993). It need not be watertight.
/// @param cell  side of the cubes, m
/// @throws BadInput unless the cell is positive
TriangleMesh simplified(const TriangleMesh& mesh, double cell);

}  // namespace palpate::geometry
