// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <optional>

#include "palpate/geometry/mesh/mesh.hpp"

namespace palpate::geometry {

using Corners = std::array<Eigen::Vector3d, 3>;

inline Corners corners(const TriangleMesh& mesh, const std::array<int, 3>& triangle) {
  return {mesh.vertices[static_cast<std::size_t>(triangle[0])],
          mesh.vertices[static_cast<std::size_t>(triangle[1])],
          mesh.vertices[static_cast<std::size_t>(triangle[2])]};
}

/// Normal of length twice the area, by the right-hand rule.
inline Eigen::Vector3d area_normal(const Corners& t) { return (t[1] - t[0]).cross(t[2] - t[0]); }

/// True if the triangle is so thin (height below 1e-6 of the longest edge) that its face has no
/// reliable normal and a point's closest point may as well be sought on its edges.
inline bool is_degenerate(const Corners& t) {
  const double longest = std::max(
      {(t[1] - t[0]).squaredNorm(), (t[2] - t[1]).squaredNorm(), (t[0] - t[2]).squaredNorm()});
  return area_normal(t).squaredNorm() <= 1e-12 * longest * longest;
}

/// Which part of a triangle a point lies on: corner k, the edge from corner k to the next, the
/// face.
enum class Feature { kCorner0, kCorner1, kCorner2, kEdge0, kEdge1, kEdge2, kFace };

struct TrianglePoint {
  Eigen::Vector3d point;
  Feature feature = Feature::kFace;
};

/// Closest point of a triangle, by the Voronoi regions of its features (Ericson, Real-Time
/// Collision Detection, 2004, 5.1.5). The triangle is not degenerate.
TrianglePoint closest_point_on_triangle(const Eigen::Vector3d& p, const Corners& t);

/// Closest point of the three edges: that of a degenerate triangle.
TrianglePoint closest_point_on_edges(const Eigen::Vector3d& p, const Corners& t);

/// Where the line origin + s direction meets the triangle (any sign of s), in units of |direction|.
///
/// Signs of the edges' triple products; two triangles that share an edge compute it exactly
/// negated, so that no line slips between them.
std::optional<double> line_triangle(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction,
                                    const Corners& t);

}  // namespace palpate::geometry
