// SPDX-License-Identifier: Apache-2.0
#include "palpate/planning/waypoints.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <span>

#include "core/csv_table.hpp"
#include "palpate/core/error.hpp"
#include "palpate/hand/joints.hpp"

namespace palpate::planning {
namespace {

constexpr std::size_t kBaseColumns = kBaseNames.size();

/// Index of a column: 0..5 the base, then the joints. @throws BadInput for another name
std::size_t column_index(std::string_view name, std::string_view source) {
  const auto base = std::find(kBaseNames.begin(), kBaseNames.end(), name);
  if (base != kBaseNames.end()) return static_cast<std::size_t>(base - kBaseNames.begin());
  const auto joint = std::find(hand::kJointNames.begin(), hand::kJointNames.end(), name);
  if (joint == hand::kJointNames.end()) {
    throw BadInput(fmt::format("{}:1: column '{}' is no joint of the hand and not {}", source, name,
                               fmt::join(kBaseNames, ", ")));
  }
  return kBaseColumns + static_cast<std::size_t>(joint - hand::kJointNames.begin());
}

constexpr std::string_view kTime = "t_s";  // first column of a planned path, which has no say here

/// What the columns mean, without that of the time.
std::vector<std::size_t> parse_header(std::span<const std::string_view> names,
                                      std::string_view source) {
  constexpr std::size_t kNarrow = hand::kJoints, kWide = kBaseColumns + hand::kJoints;
  if (names.size() != kNarrow && names.size() != kWide) {
    throw BadInput(
        fmt::format("{}:1: {} columns; waypoints have the {} joints ({} ... {}), or {} with {}",
                    source, names.size(), kNarrow, hand::kJointNames.front(),
                    hand::kJointNames.back(), kWide, fmt::join(kBaseNames, ",")));
  }
  std::vector<std::size_t> columns;
  for (std::string_view name : names) {
    columns.push_back(column_index(name, source));
    const bool again = std::count(columns.begin(), columns.end(), columns.back()) > 1;
    const bool unexpected = names.size() == kNarrow && columns.back() < kBaseColumns;
    if (again || unexpected) {
      throw BadInput(fmt::format("{}:1: column {} {}", source, name,
                                 again ? "comes twice" : "stands in the place of a joint's"));
    }
  }
  return columns;
}

Waypoint parse_row(const CsvTable& table, std::size_t first,
                   const std::vector<std::size_t>& columns, Waypoint waypoint) {
  for (std::size_t i = 0; i < columns.size(); ++i) {
    const double value = table.finite(first + i);
    const auto k = static_cast<Eigen::Index>(columns[i]);
    if (k < 3) {
      waypoint.base.xyz[k] = value;
    } else if (k < 6) {
      waypoint.base.ypr[k - 3] = value;
    } else {
      waypoint.joints[k - 6] = value;
    }
  }
  return waypoint;
}

}  // namespace

hand::HandCommand command_of(const Waypoint& waypoint) {
  return {.positions = hand::actuator_positions(waypoint.joints), .base = waypoint.base};
}

WaypointsFile parse_waypoints(std::string_view text, std::string_view source,
                              const hand::BasePosition& base) {
  CsvTable table(text, std::string(source));
  const std::size_t first = table.names().front() == kTime ? 1 : 0;
  const auto columns = parse_header(std::span(table.names()).subspan(first), source);
  WaypointsFile file;
  while (table.next()) file.waypoints.push_back(parse_row(table, first, columns, {.base = base}));
  if (file.waypoints.size() < 2) {
    throw BadInput(fmt::format("{}: a path needs at least two waypoints, not {}", source,
                               file.waypoints.size()));
  }
  file.has_base = columns.size() > hand::kJoints;
  return file;
}

}  // namespace palpate::planning
