// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <filesystem>
#include <string_view>

#include "palpate/core/error.hpp"
#include "palpate/geometry/io/mesh_io.hpp"
#include "palpate/tasks/relocate/rollout.hpp"

namespace palpate::relocate {
namespace {

constexpr std::string_view kYcbMug = "ycb-mug:";

/// Things of the mug's size and weight, m and kg.
constexpr double kMass = 0.3;
const Eigen::Vector3d kCarton(0.028, 0.028, 0.045);         // half sizes
constexpr double kBodyRadius = 0.030, kNeckRadius = 0.012;  // of the bottle
constexpr double kBodyHalf = 0.040, kNeckHalf = 0.012;      // half heights

RelocateObject box() {
  RelocateObject object;
  object.name = "box";
  object.primitives.push_back(
      {RelocatePrimitive::Shape::box, kCarton, Eigen::Isometry3d::Identity()});
  object.mass = kMass;
  const Eigen::Array3d squares = kCarton.array().square();
  object.inertia.diagonal() = kMass / 3 * (squares.sum() - squares);
  object.start_height = kCarton.z();
  return object;
}

RelocatePrimitive cylinder(double radius, double half_height, double z) {
  RelocatePrimitive part{RelocatePrimitive::Shape::cylinder, {radius, half_height, 0}, {}};
  part.T_object_part = Eigen::Translation3d(0, 0, z) * Eigen::Quaterniond::Identity();
  return part;
}

/// Its frame is in the middle of the body; the neck hardly weighs.
RelocateObject bottle() {
  RelocateObject object;
  object.name = "bottle";
  object.primitives = {cylinder(kBodyRadius, kBodyHalf, 0),
                       cylinder(kNeckRadius, kNeckHalf, kBodyHalf + kNeckHalf)};
  object.mass = kMass;
  const double r2 = kBodyRadius * kBodyRadius;
  const double across = kMass * (r2 / 4 + kBodyHalf * kBodyHalf / 3);
  object.inertia.diagonal() << across, across, kMass * r2 / 2;
  object.start_height = kBodyHalf;
  return object;
}

RelocateObject named_object(const TaskOptions& options) {
  if (options.object == "mug") return relocate_primitive_mug();
  if (options.object == "box") return box();
  if (options.object == "bottle") return bottle();
  if (options.object.starts_with(kYcbMug)) {
    return relocate_ycb_mug(geometry::load_mesh(options.object.substr(kYcbMug.size())));
  }
  std::error_code error;
  if (!std::filesystem::exists(options.object, error)) {
    throw BadInput(fmt::format(
        "task.object = {}: it is mug, ycb-mug:FILE, box, bottle, or a mesh file that exists",
        options.object));
  }
  return relocate_mesh_object(options.object, geometry::load_mesh(options.object), options.mass);
}

}  // namespace

RelocateObject make_object(const TaskOptions& options) {
  return scaled(named_object(options), options.size);
}

RelocateModel make_model(const TaskOptions& options) {
  RelocatePhysics physics;
  physics.solver = relocate_solver(options.solver);
  physics.mass_scale = options.mass_scale;
  physics.friction_scale = options.friction_scale;
  return RelocateModel(make_object(options), physics);
}

}  // namespace palpate::relocate
