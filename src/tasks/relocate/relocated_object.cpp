// SPDX-License-Identifier: Apache-2.0
#include "tasks/relocate/relocated_object.hpp"

#include <cmath>
#include <numbers>

#include "palpate/geometry/objects/shapes.hpp"

namespace palpate::relocate {
namespace {

using geometry::TriangleMesh;

constexpr int kCylinderSides = 32;

/// A cylinder about z, centred at the origin.
TriangleMesh cylinder_mesh(double radius, double half_height) {
  TriangleMesh mesh;
  for (const double z : {-half_height, half_height}) mesh.vertices.emplace_back(0, 0, z);
  for (int i = 0; i < kCylinderSides; ++i) {
    const double angle = 2 * std::numbers::pi * i / kCylinderSides;
    for (const double z : {-half_height, half_height}) {
      mesh.vertices.emplace_back(radius * std::cos(angle), radius * std::sin(angle), z);
    }
  }
  for (int i = 0; i < kCylinderSides; ++i) {
    const int low = 2 + 2 * i, next = 2 + 2 * ((i + 1) % kCylinderSides);
    mesh.triangles.push_back({0, next, low});
    mesh.triangles.push_back({1, low + 1, next + 1});
    mesh.triangles.push_back({low, next, next + 1});
    mesh.triangles.push_back({low, next + 1, low + 1});
  }
  return mesh;
}

TriangleMesh part_mesh(const RelocatePrimitive& part) {
  const TriangleMesh mesh = part.shape == RelocatePrimitive::Shape::box
                                ? geometry::box_mesh(2 * part.half)
                                : cylinder_mesh(part.half.x(), part.half.y());
  return geometry::transformed(part.T_object_part, mesh);
}

void append(const TriangleMesh& part, TriangleMesh& mesh) {
  const auto first = static_cast<int>(mesh.vertices.size());
  mesh.vertices.insert(mesh.vertices.end(), part.vertices.begin(), part.vertices.end());
  for (const auto& t : part.triangles) {
    mesh.triangles.push_back({first + t[0], first + t[1], first + t[2]});
  }
}

}  // namespace

TriangleMesh surface(const RelocateObject& object) {
  TriangleMesh mesh;
  for (const auto& part : object.primitives) append(part_mesh(part), mesh);
  for (const auto& hull : object.hulls) append(hull, mesh);
  return mesh;
}

Eigen::Isometry3d object_pose(const Eigen::VectorXd& positions) {
  const Eigen::Matrix<double, 7, 1> p = positions.tail<7>();
  return Eigen::Translation3d(p.head<3>()) *
         Eigen::Quaterniond(p[3], p[4], p[5], p[6]).normalized();
}

geometry::KnownObject known_object(const RelocateObject& object, double mass) {
  return geometry::make_known_object(object.name, surface(object), mass);
}

}  // namespace palpate::relocate
