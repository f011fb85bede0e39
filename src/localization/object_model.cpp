// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>

#include "palpate/core/error.hpp"
#include "palpate/localization/localizer.hpp"

namespace palpate::localization {
namespace {

constexpr int kSurfacePoints = 8192;

Eigen::Vector3d scaled_normal(const geometry::TriangleMesh& mesh, const std::array<int, 3>& t) {
  const auto vertex = [&mesh](int i) { return mesh.vertices[static_cast<std::size_t>(i)]; };
  return 0.5 * (vertex(t[1]) - vertex(t[0])).cross(vertex(t[2]) - vertex(t[0]));
}

Eigen::Vector3d point_in(const geometry::TriangleMesh& mesh, const std::array<int, 3>& t,
                         RandomStream& random) {
  double a = random.uniform(), b = random.uniform();
  if (a + b > 1) {
    a = 1 - a;
    b = 1 - b;
  }
  const auto vertex = [&mesh](int i) { return mesh.vertices[static_cast<std::size_t>(i)]; };
  return vertex(t[0]) + a * (vertex(t[1]) - vertex(t[0])) + b * (vertex(t[2]) - vertex(t[0]));
}

/// Points spread evenly by area: the k-th lies in the triangle where the area summed so far passes
/// (k + 1/2) / count of the whole.
std::vector<ObjectModel::SurfacePoint> sample_surface(const geometry::TriangleMesh& mesh,
                                                      double area, int count) {
  RandomStream random(0, "surface of an object model");
  std::vector<ObjectModel::SurfacePoint> points;
  double passed = 0;
  for (const auto& triangle : mesh.triangles) {
    const Eigen::Vector3d normal = scaled_normal(mesh, triangle);
    passed += normal.norm();
    while (static_cast<double>(points.size()) + 0.5 < passed / area * count) {
      points.push_back(
          {point_in(mesh, triangle, random).cast<float>(), normal.normalized().cast<float>()});
    }
  }
  return points;
}

const geometry::KnownObject& checked(const geometry::KnownObject& object) {
  if (object.mesh.triangles.empty() || object.symmetries.empty()) {
    throw BadInput(fmt::format("object model '{}': {} triangles, {} symmetries", object.name,
                               object.mesh.triangles.size(), object.symmetries.size()));
  }
  return object;
}

}  // namespace

ObjectModel::ObjectModel(geometry::KnownObject object)
    : object_(std::move(object)),
      area_(geometry::area(checked(object_).mesh)),
      field_(geometry::MeshQuery(object_.mesh)),
      surface_(sample_surface(object_.mesh, area_, kSurfacePoints)) {}

}  // namespace palpate::localization
