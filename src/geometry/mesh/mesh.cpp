// SPDX-License-Identifier: Apache-2.0
#include "palpate/geometry/mesh/mesh.hpp"

#include <algorithm>
#include <limits>

namespace palpate::geometry {

Eigen::AlignedBox3d bounds(const TriangleMesh& mesh) {
  Eigen::AlignedBox3d box;
  for (const auto& vertex : mesh.vertices) box.extend(vertex);
  return box;
}

double area(const TriangleMesh& mesh) {
  double total = 0;
  for (const auto& [i, j, k] : mesh.triangles) {
    const auto a = mesh.vertices[static_cast<std::size_t>(i)];
    const auto b = mesh.vertices[static_cast<std::size_t>(j)];
    const auto c = mesh.vertices[static_cast<std::size_t>(k)];
    total += (b - a).cross(c - a).norm() / 2;
  }
  return total;
}

double lowest_point(const Eigen::Isometry3d& T, const TriangleMesh& mesh) {
  double low = std::numeric_limits<double>::infinity();
  for (const auto& vertex : mesh.vertices) low = std::min(low, (T * vertex).z());
  return low;
}

TriangleMesh transformed(const Eigen::Isometry3d& T, TriangleMesh mesh) {
  for (auto& vertex : mesh.vertices) vertex = T * vertex;
  return mesh;
}

}  // namespace palpate::geometry
