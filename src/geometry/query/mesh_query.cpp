// SPDX-License-Identifier: Apache-2.0
#include "palpate/geometry/query/mesh_query.hpp"

#include <fmt/format.h>

#include <cmath>

#include "geometry/mesh/mesh_topology.hpp"
#include "geometry/mesh/pseudonormals.hpp"
#include "geometry/query/bvh.hpp"
#include "palpate/core/error.hpp"

namespace palpate::geometry {
namespace {

TriangleMesh checked(TriangleMesh mesh) {
  if (mesh.triangles.empty()) throw BadInput("mesh has no triangles");
  check_mesh(mesh);
  return mesh;
}

/// Directions along no axis, diagonal or plane that shapes are likely to have.
const std::array<Eigen::Vector3d, 3>& probe_directions() {
  static const std::array<Eigen::Vector3d, 3> directions = {
      Eigen::Vector3d(0.612373, 0.353917, 0.706911).normalized(),
      Eigen::Vector3d(-0.431273, 0.838211, -0.333307).normalized(),
      Eigen::Vector3d(0.274219, -0.517321, -0.810697).normalized()};
  return directions;
}

}  // namespace

struct MeshQuery::Tree {
  explicit Tree(TriangleMesh&& source)
      : mesh(checked(std::move(source))), bvh(mesh), normals(mesh) {}

  TriangleMesh mesh;
  Bvh bvh;
  Pseudonormals normals;
};

MeshQuery::MeshQuery(TriangleMesh mesh) : tree_(std::make_unique<const Tree>(std::move(mesh))) {}
MeshQuery::~MeshQuery() = default;
MeshQuery::MeshQuery(MeshQuery&&) noexcept = default;
MeshQuery& MeshQuery::operator=(MeshQuery&&) noexcept = default;

const TriangleMesh& MeshQuery::mesh() const { return tree_->mesh; }

ClosestPoint MeshQuery::closest_point(const Eigen::Vector3d& p, int guess) const {
  const Bvh::Nearest nearest = tree_->bvh.nearest(p, guess);
  if (nearest.triangle < 0) {
    throw BadInput(fmt::format("no closest point to ({}, {}, {})", p.x(), p.y(), p.z()));
  }
  return {nearest.point, tree_->normals.at(nearest.triangle, nearest.feature),
          std::sqrt(nearest.squared_distance), nearest.triangle};
}

bool MeshQuery::inside(const Eigen::Vector3d& p) const {
  const auto odd = [&](std::size_t i) {
    return tree_->bvh.count_hits(p, probe_directions()[i]) % 2 == 1;
  };
  const bool first = odd(0);
  return first == odd(1) ? first : odd(2);
}

double MeshQuery::signed_distance(const Eigen::Vector3d& p) const {
  const double distance = closest_point(p).distance;
  return inside(p) ? -distance : distance;
}

std::optional<RayHit> MeshQuery::raycast(const Eigen::Vector3d& origin,
                                         const Eigen::Vector3d& direction, double reach) const {
  return tree_->bvh.first_hit(origin, direction.normalized(), reach);
}

}  // namespace palpate::geometry
