// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "palpate/geometry/mesh/mesh.hpp"

namespace palpate::geometry {

/// Closed curve of a surface's cross-section.
using Ring = std::vector<Eigen::Vector3d>;

/// Closed surface through the `rings` (of equal size, counter-clockwise seen from the last towards
/// the first), each end capped by a fan about a point. Vertex 1 + ring * size + column is that
/// ring's.
TriangleMesh loft(const Eigen::Vector3d& start, const std::vector<Ring>& rings,
                  const Eigen::Vector3d& end);

/// Two triangles for the quadrilateral a b c d, counter-clockwise seen from outside.
void add_quad(TriangleMesh& mesh, int a, int b, int c, int d);

/// Ellipse with half axes a (x) and b (y), m, at height z; `columns` points from +x towards +y.
Ring ellipse(double a, double b, double z, int columns);

}  // namespace palpate::geometry
