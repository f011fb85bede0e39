// SPDX-License-Identifier: Apache-2.0
#include "simulation/hand/geom_mesh.hpp"

#include <cmath>
#include <numbers>
#include <vector>

#include "palpate/geometry/objects/shapes.hpp"

namespace palpate::simulation {
namespace {

using geometry::TriangleMesh;

constexpr int kSides = 24;

/// The surface that a profile sweeps about z.
/// @param profile  (distance from z, z) from bottom to top, both ends on z
TriangleMesh revolved(const std::vector<Eigen::Vector2d>& profile) {
  TriangleMesh mesh;
  const int rings = static_cast<int>(profile.size()) - 2;
  mesh.vertices.emplace_back(0, 0, profile.front().y());
  mesh.vertices.emplace_back(0, 0, profile.back().y());
  for (int ring = 1; ring <= rings; ++ring) {
    const Eigen::Vector2d& p = profile[static_cast<std::size_t>(ring)];
    for (int i = 0; i < kSides; ++i) {
      const double angle = 2 * std::numbers::pi * i / kSides;
      mesh.vertices.emplace_back(p.x() * std::cos(angle), p.x() * std::sin(angle), p.y());
    }
  }
  const auto at = [](int ring, int side) { return 2 + ring * kSides + side % kSides; };
  for (int i = 0; i < kSides; ++i) {
    mesh.triangles.push_back({0, at(0, i + 1), at(0, i)});
    mesh.triangles.push_back({1, at(rings - 1, i), at(rings - 1, i + 1)});
    for (int ring = 0; ring + 1 < rings; ++ring) {
      mesh.triangles.push_back({at(ring, i), at(ring, i + 1), at(ring + 1, i + 1)});
      mesh.triangles.push_back({at(ring, i), at(ring + 1, i + 1), at(ring + 1, i)});
    }
  }
  return mesh;
}

/// A capsule about z; a sphere if half its length is 0.
TriangleMesh capsule(double radius, double half_length) {
  constexpr int kSteps = 6;  // a quarter turn
  std::vector<Eigen::Vector2d> profile;
  for (const double end : {-1.0, 1.0}) {
    for (int i = 0; i <= kSteps; ++i) {
      const double step = end < 0 ? i - kSteps : i;
      const double angle = std::numbers::pi / 2 * step / kSteps;
      if (half_length == 0 && end > 0 && i == 0) continue;  // both halves have the equator
      profile.emplace_back(radius * std::cos(angle), end * half_length + radius * std::sin(angle));
    }
  }
  return revolved(profile);
}

TriangleMesh ellipsoid(const Eigen::Vector3d& half_axes) {
  TriangleMesh mesh = capsule(1, 0);
  for (auto& vertex : mesh.vertices) vertex = vertex.cwiseProduct(half_axes);
  return mesh;
}

TriangleMesh stored_mesh(const mjModel& model, int mesh) {
  TriangleMesh result;
  const float* const vertices = model.mesh_vert + 3 * model.mesh_vertadr[mesh];
  for (int i = 0; i < model.mesh_vertnum[mesh]; ++i) {
    result.vertices.push_back(Eigen::Vector3f(vertices + 3 * i).cast<double>());
  }
  const int* const faces = model.mesh_face + 3 * model.mesh_faceadr[mesh];
  for (int i = 0; i < model.mesh_facenum[mesh]; ++i) {
    result.triangles.push_back({faces[3 * i], faces[3 * i + 1], faces[3 * i + 2]});
  }
  return result;
}

}  // namespace

TriangleMesh geom_mesh(const mjModel& model, int geom) {
  const Eigen::Vector3d size(model.geom_size + 3 * geom);
  switch (model.geom_type[geom]) {
    case mjGEOM_MESH:
      return stored_mesh(model, model.geom_dataid[geom]);
    case mjGEOM_BOX:
      return geometry::box_mesh(2 * size);
    case mjGEOM_SPHERE:
      return capsule(size.x(), 0);
    case mjGEOM_ELLIPSOID:
      return ellipsoid(size);
    case mjGEOM_CAPSULE:
      return capsule(size.x(), size.y());
    case mjGEOM_CYLINDER:
      return revolved({{0, -size.y()}, {size.x(), -size.y()}, {size.x(), size.y()}, {0, size.y()}});
    default:
      return {};
  }
}

}  // namespace palpate::simulation
