// SPDX-License-Identifier: Apache-2.0
#include "geometry/mesh/loft.hpp"

#include <cmath>
#include <numbers>

namespace palpate::geometry {

void add_quad(TriangleMesh& mesh, int a, int b, int c, int d) {
  mesh.triangles.push_back({a, b, c});
  mesh.triangles.push_back({a, c, d});
}

TriangleMesh loft(const Eigen::Vector3d& start, const std::vector<Ring>& rings,
                  const Eigen::Vector3d& end) {
  TriangleMesh mesh;
  const int columns = static_cast<int>(rings.front().size());
  const int last_ring = static_cast<int>(rings.size()) - 1;
  mesh.vertices.push_back(start);
  for (const Ring& ring : rings) {
    mesh.vertices.insert(mesh.vertices.end(), ring.begin(), ring.end());
  }
  const int end_vertex = static_cast<int>(mesh.vertices.size());
  mesh.vertices.push_back(end);

  const auto vertex = [&](int ring, int column) { return 1 + ring * columns + column % columns; };
  for (int j = 0; j < columns; ++j) {
    mesh.triangles.push_back({0, vertex(0, j + 1), vertex(0, j)});
    for (int i = 0; i < last_ring; ++i) {
      add_quad(mesh, vertex(i, j), vertex(i, j + 1), vertex(i + 1, j + 1), vertex(i + 1, j));
    }
    mesh.triangles.push_back({end_vertex, vertex(last_ring, j), vertex(last_ring, j + 1)});
  }
  return mesh;
}

Ring ellipse(double a, double b, double z, int columns) {
  Ring ring;
  for (int j = 0; j < columns; ++j) {
    const double angle = 2 * std::numbers::pi * j / columns;
    ring.emplace_back(a * std::cos(angle), b * std::sin(angle), z);
  }
  return ring;
}

}  // namespace palpate::geometry
