// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Geometry>
#include <array>
#include <vector>

namespace palpate::geometry {

/// Triangle mesh in metres; triangles wind counter-clockwise seen from outside.
struct TriangleMesh {
  std::vector<Eigen::Vector3d> vertices;
  std::vector<std::array<int, 3>> triangles;
};

/// Smallest axis-aligned box that holds all vertices; empty for a mesh without vertices.
Eigen::AlignedBox3d bounds(const TriangleMesh& mesh);

/// Surface area, m^2.
double area(const TriangleMesh& mesh);

/// Height (m) of the lowest vertex, along z of the frame to which T leads; infinite for a mesh
/// without vertices.
double lowest_point(const Eigen::Isometry3d& T, const TriangleMesh& mesh);

/// The mesh moved by T.
TriangleMesh transformed(const Eigen::Isometry3d& T, TriangleMesh mesh);

}  // namespace palpate::geometry
