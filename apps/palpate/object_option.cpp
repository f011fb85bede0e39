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
constexpr double kSizeStep = 0.05;     // of sizes that are compared, at most
constexpr double kMillimetre = 0.001;  // m
constexpr double kReach = 3;           // m of a rough place along x and y
constexpr double kRoughest = 0.1;      // m

bool is_mesh_file(const std::string& sized_name) {
  const std::string name = geometry::sized_name(sized_name).name;
  const auto& built_in = geometry::built_in_objects();
  std::error_code error;
  return std::ranges::find(built_in, name) == built_in.end() &&
         std::filesystem::is_regular_file(name, error);
}

/// The same for all spellings of a mesh file's path and of a size.
std::string identity_of(const std::string& name) {
  const geometry::SizedName sized = geometry::sized_name(name);
  std::string identity = sized.name;
  if (is_mesh_file(sized.name)) {
    std::error_code error;
    const auto path = std::filesystem::canonical(sized.name, error);
    if (!error) identity = path.string();
  }
  return sized.size == 1 ? identity : fmt::format("{}@{}", identity, sized.size);
}

}  // namespace

void add_units_option(CLI::App& command, std::string& units) {
  command.add_option("--units", units, "unit of length of the mesh files")
      ->check(CLI::IsMember({"m", "mm"}))
      ->capture_default_str();
}

geometry::KnownObject load_object(const std::string& name, const std::string& units) {
  if (units == "m" || !is_mesh_file(name)) return geometry::load_known_object(name);
  const geometry::SizedName sized = geometry::sized_name(name);
  geometry::TriangleMesh mesh = geometry::load_mesh(sized.name);
  for (auto& vertex : mesh.vertices) vertex *= kMillimetre;
  geometry::KnownObject object = geometry::make_known_object(sized.name, mesh, 0);
  object.name = std::filesystem::path(sized.name).stem().string();
  return geometry::resized(std::move(object), sized.size);
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

CLI::Option* add_size_range_option(CLI::App& command, double& size_range) {
  return command
      .add_option("--size-range", size_range,
                  "share by which the object may be larger or smaller than its mesh; its size is "
                  "then estimated, too")
      ->check(in_range(0.0, 0.2))
      ->option_text("R");
}

std::vector<std::string> with_sizes(const std::vector<std::string>& names, double size_range) {
  require_distinct(names);
  std::vector<std::string> all = names;
  const int steps = static_cast<int>(std::ceil(size_range / kSizeStep - 1e-9));
  for (const std::string& name : names) {
    const geometry::SizedName sized = geometry::sized_name(name);
    for (int i = 1; i <= steps; ++i) {
      for (const double sign : {-1.0, 1.0}) {
        const double size = sized.size * (1 + sign * i * size_range / steps);
        all.push_back(fmt::format("{}@{:.4g}", sized.name, size));
      }
    }
  }
  require_distinct(all);
  return all;
}

std::vector<geometry::ObjectModel> load_models(const std::vector<std::string>& names,
                                               const ObjectArguments& arguments) {
  std::vector<geometry::ObjectModel> models;
  for (const std::string& name : names) models.emplace_back(load_object(name, arguments));
  for (std::size_t j = 1; j < names.size(); ++j) {
    for (std::size_t i = 0; i < j; ++i) {
      const bool is_taken_for_one = geometry::is_same_shape(models[i].object(), models[j].object());
      const bool is_one =
          is_same_object(geometry::sized_name(names[i]).name, geometry::sized_name(names[j]).name);
      if (!is_taken_for_one || is_one) continue;
      throw BadInput(fmt::format("{} and {} would be sizes of one object, as both are called {}",
                                 names[i], names[j], models[i].object().name));
    }
  }
  return models;
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

std::string short_name(const std::string& name) {
  const std::string of_shape = geometry::sized_name(name).name;
  return std::filesystem::path(of_shape).stem().string() + name.substr(of_shape.size());
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
  if (names.size() > 1 && arguments.mass) {
    throw BadInput(fmt::format("--mass {} is of one object, not of {} objects", *arguments.mass,
                               names.size()));
  }
  CandidateObjects objects{with_sizes(names, arguments.size_range), {}};
  if (objects.names.size() > kMaxCandidates) {
    throw BadInput(
        fmt::format("{} objects of which one may stand there, at most {} are compared{}",
                    objects.names.size(), kMaxCandidates,
                    arguments.size_range > 0
                        ? fmt::format(" (--size-range {} is {} sizes of each)",
                                      arguments.size_range, objects.names.size() / names.size())
                        : ""));
  }
  objects.models = load_models(objects.names, arguments);
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
