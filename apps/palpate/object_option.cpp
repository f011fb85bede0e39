// SPDX-License-Identifier: Apache-2.0
#include "object_option.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <map>
#include <string_view>

#include "palpate/core/error.hpp"
#include "palpate/geometry/io/mesh_io.hpp"
#include "usage.hpp"

namespace palpate::app {
namespace {

constexpr std::size_t kMaxCandidates = 10;
constexpr double kMillimetre = 0.001;  // m
constexpr double kReach = 3;           // m of a rough place along x and y
constexpr double kRoughest = 0.1;      // m

bool is_mesh_file(const std::string& name) {
  const auto& built_in = geometry::built_in_objects();
  std::error_code error;
  return std::ranges::find(built_in, name) == built_in.end() &&
         std::filesystem::is_regular_file(name, error);
}

/// The same for all spellings of a mesh file's path.
std::string identity_of(const std::string& name) {
  if (!is_mesh_file(name)) return name;
  std::error_code error;
  const auto path = std::filesystem::canonical(name, error);
  return error ? name : path.string();
}

}  // namespace

void add_units_option(CLI::App& command, std::string& units) {
  command.add_option("--units", units, "unit of length of the mesh files")
      ->check(CLI::IsMember({"m", "mm"}))
      ->capture_default_str();
}

geometry::KnownObject load_object(const std::string& name, const std::string& units) {
  if (units == "m" || !is_mesh_file(name)) return geometry::load_known_object(name);
  geometry::TriangleMesh mesh = geometry::load_mesh(name);
  for (auto& vertex : mesh.vertices) vertex *= kMillimetre;
  geometry::KnownObject object = geometry::make_known_object(name, mesh, 0);
  object.name = std::filesystem::path(name).stem().string();
  return object;
}

void require_mesh_file(const std::vector<std::string>& names, const std::string& units) {
  if (units == "m" || std::ranges::any_of(names, is_mesh_file)) return;
  throw BadInput(fmt::format("--units {} is of mesh files, and {} {}", units,
                             fmt::join(names, ", "), names.size() == 1 ? "is none" : "are none"));
}

void print_repairs(const std::string& name, const std::vector<std::string>& repairs) {
  for (const auto& repair : repairs) fmt::print("mesh of {} repaired: {}\n", name, repair);
}

void add_object_options(CLI::App& command, ObjectArguments& arguments) {
  command
      .add_option("--mass", arguments.mass,
                  "mass of the object, kg (default: from its volume, between 0.05 and 0.6)")
      ->check(in_range(0.001, 5.0));
  command
      .add_option("--at", arguments.at,
                  "approximate position of the object on the table, m, to within +- R "
                  "(default: 0,0,0.04)")
      ->option_text("X,Y[,R]");
  add_units_option(command, arguments.units);
}

geometry::KnownObject load_object(const std::string& name, const ObjectArguments& arguments) {
  geometry::KnownObject object = load_object(name, arguments.units);
  if (!arguments.mass) return object;
  object.mass = *arguments.mass;
  object.mass_properties = geometry::mass_properties(object.mesh, object.mass);
  return object;
}

estimation::Candidates CandidateObjects::candidates() const {
  estimation::Candidates candidates;
  for (const auto& model : models) candidates.push_back(&model);
  return candidates;
}

const geometry::ObjectModel* CandidateObjects::find(const std::string& name) const {
  const auto found = std::ranges::find_if(
      names, [&](const std::string& one) { return is_same_object(one, name); });
  return found == names.end() ? nullptr : &models[static_cast<std::size_t>(found - names.begin())];
}

bool is_same_object(const std::string& a, const std::string& b) {
  return identity_of(a) == identity_of(b);
}

void require_distinct(const std::vector<std::string>& names) {
  std::map<std::string, std::string_view> seen;  // names by what they are of
  for (const auto& name : names) {
    const auto [before, is_new] = seen.try_emplace(identity_of(name), name);
    if (is_new) continue;
    throw BadInput(fmt::format(
        "{} is given twice{}", name,
        before->second == name ? "" : fmt::format(", the other time as {}", before->second)));
  }
}

CandidateObjects load_objects(const std::vector<std::string>& names,
                              const ObjectArguments& arguments) {
  if (names.size() > kMaxCandidates) {
    throw BadInput(fmt::format("{} objects of which one may stand there, at most {} are compared",
                               names.size(), kMaxCandidates));
  }
  if (names.size() > 1 && arguments.mass) {
    throw BadInput(fmt::format("--mass {} is of one object, not of {} objects", *arguments.mass,
                               names.size()));
  }
  CandidateObjects objects{names, {}};
  require_distinct(names);
  for (const auto& name : names) objects.models.emplace_back(load_object(name, arguments));
  return objects;
}

void apply_place(const ObjectArguments& arguments, const std::vector<std::string>& settings,
                 evaluation::StartOptions& start) {
  if (arguments.at.empty()) return;
  char end = 0;
  double x = 0, y = 0, r = start.uncertainty;
  const char* const text = arguments.at.c_str();
  const bool read = std::sscanf(text, "%lf,%lf%c", &x, &y, &end) == 2 ||
                    std::sscanf(text, "%lf,%lf,%lf%c", &x, &y, &r, &end) == 3;
  const bool within = std::abs(x) <= kReach && std::abs(y) <= kReach && r >= 0 && r <= kRoughest;
  if (!read || !within) {
    throw BadInput(
        fmt::format("--at {}: it is X,Y or X,Y,R in metres, X and Y within +-{}, R "
                    "from 0 to {}",
                    arguments.at, kReach, kRoughest));
  }
  const bool is_set = start.uncertainty != evaluation::StartOptions{}.uncertainty ||
                      std::ranges::any_of(settings, [](const std::string& setting) {
                        return setting.starts_with("start.uncertainty");
                      });
  if (is_set && start.uncertainty != r) {
    throw BadInput(fmt::format("--at {}: start.uncertainty is set to {}; give R in one of them",
                               arguments.at, start.uncertainty));
  }
  start.x = x;
  start.y = y;
  start.uncertainty = r;
}

}  // namespace palpate::app
