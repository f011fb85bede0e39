// SPDX-License-Identifier: Apache-2.0
#include "palpate/geometry/objects/known_object.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <charconv>
#include <filesystem>
#include <limits>

#include "geometry/objects/stable_poses.hpp"
#include "geometry/objects/symmetry.hpp"
#include "palpate/core/assets.hpp"
#include "palpate/core/error.hpp"
#include "palpate/core/plausible.hpp"
#include "palpate/core/spelling.hpp"
#include "palpate/geometry/io/mesh_io.hpp"
#include "palpate/geometry/objects/generated_shape.hpp"
#include "palpate/geometry/objects/shapes.hpp"
#include "palpate/geometry/repair/mesh_repair.hpp"

namespace palpate::geometry {
namespace {

constexpr double kLeastFactor = 0.1;                   // of a size after @
constexpr double kSmallest = 0.010, kLargest = 0.400;  // m, of the longest side
constexpr double kDensity = 300;                       // kg/m^3, of a file's mesh
constexpr double kLightest = 0.05, kHeaviest = 0.6;    // kg, of a file's mesh

struct BuiltIn {
  TriangleMesh mesh;
  double mass = 0;  ///< kg
};

BuiltIn built_in(const std::string& name) {
  if (name == "mug") return {mug_mesh(), 0.12};
  if (name == "bottle") return {bottle_mesh(), 0.40};
  if (name == "box") return {box_mesh({0.050, 0.094, 0.175}), 0.40};
  if (name == "bracket") return {bracket_mesh(), 0.25};
  return {duck_mesh(), 0.20};
}

constexpr const char* kBunny = "bunny";  // a test object, not for commercial use

KnownObject bunny() {
  std::filesystem::path file;
  try {
    file = asset("bunny.ply");
  } catch (const BadInput&) {
    throw BadInput(
        "the bunny is not installed, because its licence forbids commercial use (see "
        "docs/licences.md): ./dev bunny installs it; the built-in free-form object is 'duck'");
  }
  return make_known_object(kBunny, load_mesh(file), 0.20);
}

/// The object that a misspelt name likely means: "; did you mean 'mug'?", or 'generated:5' for
/// Generated:5 and generate:5.
std::string suggestion_for(const std::string& name) {
  std::vector<std::string> names = built_in_objects();
  if (const auto colon = name.find(':'); colon != std::string::npos) {
    const std::string generated = "generated" + name.substr(colon);
    if (generated_seed(generated)) names.push_back(generated);
  }
  return did_you_mean(name, names);
}

[[noreturn]] void refuse_name(const std::string& name) {
  throw BadInput(
      fmt::format("'{}' is neither a mesh file nor a built-in object ({}, generated:SEED){}", name,
                  fmt::join(built_in_objects(), ", "), suggestion_for(name)));
}

/// @throws BadInput, naming the object, if its mesh cannot be repaired
RepairedMesh repair_named(const std::string& name, const TriangleMesh& mesh) {
  try {
    return repair(mesh);
  } catch (const BadInput& error) {
    throw BadInput(fmt::format("{}: {}", name, error.what()));
  }
}

/// Refuses an object that a hand cannot hold. Vertices of no triangle do not count.
void check_size(const std::string& name, const TriangleMesh& mesh) {
  Eigen::AlignedBox3d box;
  for (const auto& triangle : mesh.triangles) {
    for (const int i : triangle) box.extend(mesh.vertices.at(static_cast<std::size_t>(i)));
  }
  const Eigen::Vector3d size = (box.isEmpty() ? bounds(mesh) : box).sizes();
  const double longest = size.maxCoeff();
  if (longest >= kSmallest && longest <= kLargest) return;
  const std::string measured =
      fmt::format("{} measures {:.4g} x {:.4g} x {:.4g} m", name, size.x(), size.y(), size.z());
  const double as_millimetres = longest / 1000;
  if (longest > 1 && as_millimetres >= kSmallest && as_millimetres <= kLargest) {
    throw BadInput(
        measured +
        ": its mesh looks as if it were in millimetres; scale it by 0.001, or give --units mm to "
        "palpate pick, eval or localize");
  }
  throw BadInput(fmt::format("{}; its longest side must be {:.0f} to {:.0f} mm", measured,
                             1e3 * kSmallest, 1e3 * kLargest));
}

}  // namespace

double top_of(const KnownObject& object, const StablePose& stable_pose) {
  double top = -std::numeric_limits<double>::infinity();
  for (const auto& vertex : object.mesh.vertices) {
    top = std::max(top, stable_pose.R_table_object.row(2).dot(vertex));
  }
  return top + stable_pose.height;
}

const std::vector<std::string>& built_in_objects() {
  static const std::vector<std::string> names = {"mug", "bottle", "box", "bracket", "duck"};
  return names;
}

KnownObject make_known_object(const std::string& name, const TriangleMesh& mesh, double mass) {
  check_size(name, mesh);
  RepairedMesh repaired = repair_named(name, mesh);
  KnownObject object;
  object.name = name;
  object.repairs = std::move(repaired.actions);
  const MassProperties in_file = mass_properties(repaired.mesh, 1);
  object.mass = mass > 0 ? mass : std::clamp(kDensity * in_file.volume, kLightest, kHeaviest);
  object.T_mesh_object.translation() = in_file.centroid;
  object.mesh = transformed(object.T_mesh_object.inverse(), std::move(repaired.mesh));
  object.mass_properties = mass_properties(object.mesh, object.mass);
  object.stable_poses = stable_poses(object.mesh, Eigen::Vector3d::Zero());
  object.symmetries = rotational_symmetries(object.mesh, Eigen::Vector3d::Zero());
  return object;
}

KnownObject resized(KnownObject object, double factor) {
  for (auto& vertex : object.mesh.vertices) vertex *= factor;
  check_size(object.name, object.mesh);
  object.T_mesh_object.translation() *= factor;
  object.mass *= factor * factor * factor;
  object.mass_properties = mass_properties(object.mesh, object.mass);
  for (StablePose& stable_pose : object.stable_poses) stable_pose.height *= factor;
  object.size *= factor;
  return object;
}

bool is_same_shape(const KnownObject& a, const KnownObject& b) {
  return &a == &b || (a.name == b.name && a.size != b.size);
}

SizedName sized_name(const std::string& name) {
  const std::size_t at = name.rfind('@');
  std::error_code unknown;  // of a name too long for a file, for one
  if (at == std::string::npos || std::filesystem::exists(name, unknown)) return {name};
  double size = 0;
  const char* const begin = name.data() + at + 1;
  const char* const end = name.data() + name.size();
  const auto read = std::from_chars(begin, end, size);
  if (read.ec != std::errc() || read.ptr != end) return {name};
  return {name.substr(0, at),
          plausible(size, kLeastFactor, 1 / kLeastFactor, "the size in " + name)};
}

KnownObject load_known_object(const std::string& name_or_file) {
  if (const SizedName sized = sized_name(name_or_file); sized.name != name_or_file) {
    return resized(load_known_object(sized.name), sized.size);
  }
  if (const auto seed = generated_seed(name_or_file)) {
    return make_known_object(name_or_file, generated_shape(*seed), 0);
  }
  if (name_or_file == kBunny) return bunny();
  const bool is_built_in = std::ranges::count(built_in_objects(), name_or_file) > 0;
  std::error_code unknown;  // of a name too long for a file, for one
  if (!is_built_in && !std::filesystem::exists(name_or_file, unknown)) refuse_name(name_or_file);
  if (is_built_in) {
    const BuiltIn source = built_in(name_or_file);
    return make_known_object(name_or_file, source.mesh, source.mass);
  }
  KnownObject object = make_known_object(name_or_file, load_mesh(name_or_file), 0);
  object.name = std::filesystem::path(name_or_file).stem().string();
  return object;
}

}  // namespace palpate::geometry
