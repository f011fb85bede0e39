// SPDX-License-Identifier: Apache-2.0
#include "geometry/mesh/pseudonormals.hpp"

#include <cmath>
#include <map>

#include "geometry/mesh/weld.hpp"

namespace palpate::geometry {
namespace {

using Edge = std::pair<int, int>;

Edge edge_between(int a, int b) { return {std::min(a, b), std::max(a, b)}; }

double angle_at(const Corners& t, std::size_t k) {
  const Eigen::Vector3d u = t[(k + 1) % 3] - t[k], v = t[(k + 2) % 3] - t[k];
  return std::atan2(u.cross(v).norm(), u.dot(v));
}

/// Unit vector along `sum`; `otherwise` where sheets that touch cancel.
Eigen::Vector3d direction(const Eigen::Vector3d& sum, const Eigen::Vector3d& otherwise) {
  const double length = sum.norm();
  return length > 1e-9 ? Eigen::Vector3d(sum / length) : otherwise;
}

}  // namespace

Pseudonormals::Pseudonormals(const TriangleMesh& mesh) : normals_(mesh.triangles.size()) {
  const std::vector<int> first = first_at_same_position(mesh);
  const auto welded = [&](std::size_t triangle, std::size_t k) {
    return first[static_cast<std::size_t>(mesh.triangles[triangle][k % 3])];
  };
  std::vector<Eigen::Vector3d> vertex_sum(mesh.vertices.size(), Eigen::Vector3d::Zero());
  std::map<Edge, Eigen::Vector3d> edge_sum;
  constexpr auto kFace = static_cast<std::size_t>(Feature::kFace);
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    const Corners t = corners(mesh, mesh.triangles[i]);
    Eigen::Vector3d& normal = normals_[i][kFace];
    normal = is_degenerate(t) ? Eigen::Vector3d::Zero() : area_normal(t).normalized().eval();
    for (std::size_t k = 0; k < 3; ++k) {
      vertex_sum[static_cast<std::size_t>(welded(i, k))] += angle_at(t, k) * normal;
      edge_sum.try_emplace(edge_between(welded(i, k), welded(i, k + 1)), Eigen::Vector3d::Zero())
          .first->second += normal;
    }
  }
  for (std::size_t i = 0; i < normals_.size(); ++i) {
    Eigen::Vector3d& face = normals_[i][kFace];
    face = direction(face, Eigen::Vector3d::UnitZ());  // a degenerate face has no normal of its own
    for (std::size_t k = 0; k < 3; ++k) {
      normals_[i][k] = direction(vertex_sum[static_cast<std::size_t>(welded(i, k))], face);
      const Edge edge = edge_between(welded(i, k), welded(i, k + 1));
      normals_[i][k + 3] = direction(edge_sum.at(edge), face);
    }
  }
}

}  // namespace palpate::geometry
