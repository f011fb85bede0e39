// SPDX-License-Identifier: Apache-2.0
#include "palpate/tasks/relocate/relocate_object.hpp"

#include <fmt/format.h>

#include <cmath>
#include <numbers>

#include "palpate/core/error.hpp"
#include "palpate/geometry/mesh/mass_properties.hpp"
#include "palpate/simulation/world/convex_parts.hpp"

namespace palpate::relocate {
namespace {

constexpr double kMugScale = 0.8;
constexpr double kMugMass = 0.301;           // kg
constexpr double kMugStartHeight = 0.04065;  // m; the published task drops the mug by 9 mm

// The scaled YCB mug in its own frame, m.
const Eigen::Vector2d kAxis(-0.0029, 0.0006);
constexpr double kRadius = 0.0329, kWall = 0.0032;
constexpr double kLow = -0.0312, kHigh = 0.0339, kFloor = 0.0020;
constexpr int kSides = 12;
constexpr double kHandleY = -0.0016, kHandleHalf = 0.0050;

using Shape = RelocatePrimitive::Shape;

RelocatePrimitive box(const Eigen::Vector3d& low, const Eigen::Vector3d& high) {
  RelocatePrimitive part{Shape::box, (high - low) / 2, Eigen::Isometry3d::Identity()};
  part.T_object_part.translation() = (low + high) / 2;
  return part;
}

RelocatePrimitive side(int index) {
  const double angle = 2 * std::numbers::pi * index / kSides;
  const double tangent = kRadius * std::tan(std::numbers::pi / kSides);
  RelocatePrimitive part{Shape::box, {kWall / 2, tangent, (kHigh - kLow) / 2}, {}};
  part.T_object_part = Eigen::Translation3d(kAxis.x(), kAxis.y(), (kHigh + kLow) / 2) *
                       Eigen::AngleAxisd(angle, Eigen::Vector3d::UnitZ()) *
                       Eigen::Translation3d(kRadius - kWall / 2, 0, 0);
  return part;
}

RelocatePrimitive mug_floor() {
  RelocatePrimitive part{Shape::cylinder, {kRadius - kWall, kFloor / 2, 0}, {}};
  part.T_object_part = Eigen::Translation3d(kAxis.x(), kAxis.y(), kLow + kFloor / 2) *
                       Eigen::Quaterniond::Identity();
  return part;
}

RelocatePrimitive handle_bar(double x_low, double x_high, double z_low, double z_high) {
  return box({x_low, kHandleY - kHandleHalf, z_low}, {x_high, kHandleY + kHandleHalf, z_high});
}

/// Mass and start of the mug, whatever its shape. The inertia is that of a full cylinder with the
/// mug's outline, which is what the mass stands for: the published model's compiler filled the mug.
RelocateObject bare_mug(const std::string& name) {
  RelocateObject object;
  object.name = name;
  object.mass = kMugMass;
  object.center << kAxis.x(), kAxis.y(), (kHigh + kLow) / 2;
  const double across = kMugMass * (3 * kRadius * kRadius + std::pow(kHigh - kLow, 2)) / 12;
  object.inertia.diagonal() << across, across, kMugMass * kRadius * kRadius / 2;
  object.start_height = kMugStartHeight;
  object.start_rotation = Eigen::AngleAxisd(std::numbers::pi / 2, Eigen::Vector3d::UnitZ());
  return object;
}

}  // namespace

RelocateObject relocate_primitive_mug() {
  RelocateObject object = bare_mug("mug");
  for (int i = 0; i < kSides; ++i) object.primitives.push_back(side(i));
  object.primitives.push_back(mug_floor());
  object.primitives.push_back(handle_bar(0.0295, 0.0480, 0.0168, 0.0236));
  object.primitives.push_back(handle_bar(0.0465, 0.0532, -0.0120, 0.0180));
  object.primitives.push_back(handle_bar(0.0295, 0.0480, -0.0195, -0.0125));
  return object;
}

RelocateObject relocate_ycb_mug(const geometry::TriangleMesh& mesh) {
  RelocateObject object = bare_mug("ycb-mug");
  geometry::TriangleMesh scaled = mesh;
  for (auto& vertex : scaled.vertices) vertex *= kMugScale;
  object.hulls = simulation::convex_parts(scaled);
  return object;
}

RelocateObject scaled(RelocateObject object, double scale) {
  if (!(std::isfinite(scale) && scale > 0)) {
    throw BadInput(fmt::format("the size of {} must be positive, not {}", object.name, scale));
  }
  for (auto& part : object.primitives) {
    part.half *= scale;
    part.T_object_part.translation() *= scale;
  }
  for (auto& hull : object.hulls) {
    for (auto& vertex : hull.vertices) vertex *= scale;
  }
  object.center *= scale;
  object.inertia *= scale * scale;
  object.start_height *= scale;
  return object;
}

RelocateObject relocate_mesh_object(const std::string& name, const geometry::TriangleMesh& mesh,
                                    double mass) {
  if (!(std::isfinite(mass) && mass > 0)) {
    throw BadInput(fmt::format("the mass of {} must be positive, not {}", name, mass));
  }
  const auto properties = geometry::mass_properties(mesh, mass);
  const Eigen::Isometry3d T_center_mesh(Eigen::Translation3d(-properties.centroid));
  const auto centered = geometry::transformed(T_center_mesh, mesh);
  RelocateObject object;
  object.name = name;
  object.hulls = simulation::convex_parts(centered);
  object.mass = mass;
  object.inertia = properties.inertia;
  object.start_height = -geometry::bounds(centered).min().z();
  return object;
}

}  // namespace palpate::relocate
