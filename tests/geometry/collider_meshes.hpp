// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <numbers>
#include <vector>

#include "palpate/core/random.hpp"
#include "palpate/geometry/mesh/mesh.hpp"

namespace palpate::geometry {

inline TriangleMesh torus(double major, double minor, int around, int across) {
  TriangleMesh mesh;
  for (int i = 0; i < around; ++i) {
    for (int j = 0; j < across; ++j) {
      const double u = 2 * std::numbers::pi * i / around, v = 2 * std::numbers::pi * j / across;
      const double r = major + minor * std::cos(v);
      mesh.vertices.emplace_back(r * std::cos(u), r * std::sin(u), minor * std::sin(v));
      const int i1 = (i + 1) % around, j1 = (j + 1) % across;
      mesh.triangles.push_back({i * across + j, i1 * across + j, i1 * across + j1});
      mesh.triangles.push_back({i * across + j, i1 * across + j1, i * across + j1});
    }
  }
  return mesh;
}

/// Prism of an outline that is star-shaped about its first corner, counter-clockwise, centred in z.
inline TriangleMesh prism(const std::vector<Eigen::Vector2d>& outline, double height) {
  TriangleMesh mesh;
  const int n = static_cast<int>(outline.size());
  for (double z : {-0.5 * height, 0.5 * height}) {
    for (const Eigen::Vector2d& p : outline) mesh.vertices.emplace_back(p.x(), p.y(), z);
  }
  for (int i = 0; i < n; ++i) {
    const int next = (i + 1) % n;
    mesh.triangles.push_back({i, next, n + next});
    mesh.triangles.push_back({i, n + next, n + i});
    if (i == 0 || next == 0) continue;
    mesh.triangles.push_back({0, next, i});
    mesh.triangles.push_back({n, n + i, n + next});
  }
  return mesh;
}

inline TriangleMesh slab(double x, double y, double z) {
  return prism({{-x / 2, -y / 2}, {x / 2, -y / 2}, {x / 2, y / 2}, {-x / 2, y / 2}}, z);
}

/// An L whose inner corner is the z axis.
inline TriangleMesh bracket() {
  return prism({{0, 0}, {0, 0.06}, {-0.02, 0.06}, {-0.02, -0.02}, {0.06, -0.02}, {0.06, 0}}, 0.08);
}

/// A point at the given signed distance from some place of the surface, along its normal.
inline Eigen::Vector3d near_surface(const TriangleMesh& mesh, double offset, RandomStream& random) {
  const auto& t = mesh.triangles[random.index(mesh.triangles.size())];
  const auto corner = [&](std::size_t k) { return mesh.vertices[static_cast<std::size_t>(t[k])]; };
  const double u = std::sqrt(random.uniform()), v = random.uniform();
  const Eigen::Vector3d p = (1 - u) * corner(0) + u * (1 - v) * corner(1) + u * v * corner(2);
  const Eigen::Vector3d n = (corner(1) - corner(0)).cross(corner(2) - corner(0)).normalized();
  return p + offset * n;
}

/// What colliders are tried on: a torus, an L, a plate.
inline TriangleMesh collider_mesh(int shape) {
  return shape == 0 ? torus(0.03, 0.012, 48, 24) : shape == 1 ? bracket() : slab(0.05, 0.07, 0.004);
}

}  // namespace palpate::geometry
