// SPDX-License-Identifier: Apache-2.0
#include "palpate/geometry/objects/object_model.hpp"

#include <fmt/format.h>

#include "geometry/mesh/convex_hull.hpp"
#include "geometry/query/clearance.hpp"
#include "palpate/core/error.hpp"
#include "palpate/geometry/mesh/sampling.hpp"

namespace palpate::geometry {
namespace {

constexpr std::size_t kSurfacePoints = 8192;

std::vector<ObjectModel::SurfacePoint> surface_points(const TriangleMesh& mesh) {
  const RandomStream random(0, "surface of an object model");
  std::vector<ObjectModel::SurfacePoint> points;
  for (const auto& sample : sample_surface(mesh, kSurfacePoints, random)) {
    points.push_back({sample.point.cast<float>(), sample.normal.cast<float>()});
  }
  return points;
}

const KnownObject& checked(const KnownObject& object) {
  if (object.mesh.triangles.empty() || object.symmetries.empty()) {
    throw BadInput(fmt::format("object model '{}': {} triangles, {} symmetries", object.name,
                               object.mesh.triangles.size(), object.symmetries.size()));
  }
  return object;
}

}  // namespace

ObjectModel::ObjectModel(KnownObject object)
    : object_(std::move(object)),
      area_(geometry::area(checked(object_).mesh)),
      bounds_(geometry::bounds(object_.mesh).cast<float>()),
      field_(MeshQuery(object_.mesh)),
      surface_(surface_points(object_.mesh)),
      clearance_(std::make_unique<const Clearance>(field_, object_.mesh)) {
  const std::vector<Eigen::Vector3d> hull = hull_corners(object_.mesh.vertices);
  for (const Eigen::Vector3d& corner : hull) hull_.push_back(corner.cast<float>());
  for (const StablePose& pose : object_.stable_poses) resting_slack_.emplace_back(hull, pose);
}

ObjectModel::~ObjectModel() = default;
ObjectModel::ObjectModel(ObjectModel&&) noexcept = default;

}  // namespace palpate::geometry
