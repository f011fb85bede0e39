// SPDX-License-Identifier: Apache-2.0
#include "palpate/planning/waypoints.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <span>

#include "core/csv_table.hpp"
#include "palpate/core/error.hpp"
#include "palpate/hand/kinematics.hpp"

namespace palpate::planning {
namespace {

constexpr std::size_t kMountColumns = kMountNames.size();

/// Index of a column: 0..5 the mount, then the joints. @throws BadInput for another name
std::size_t column_index(const hand::Description& hand, std::string_view name,
                         std::string_view source) {
  const auto mount = std::find(kMountNames.begin(), kMountNames.end(), name);
  if (mount != kMountNames.end()) return static_cast<std::size_t>(mount - kMountNames.begin());
  const auto joint = std::find_if(hand.joints.begin(), hand.joints.end(),
                                  [&](const hand::Joint& one) { return one.name == name; });
  if (joint == hand.joints.end()) {
    throw BadInput(fmt::format("{}:1: column '{}' is no joint of the hand and not {}", source, name,
                               fmt::join(kMountNames, ", ")));
  }
  return kMountColumns + static_cast<std::size_t>(joint - hand.joints.begin());
}

constexpr std::string_view kTime = "t_s";  // first column of a planned path, which has no say here

/// What the columns mean, without that of the time.
std::vector<std::size_t> parse_header(const hand::Description& hand,
                                      std::span<const std::string_view> names,
                                      std::string_view source) {
  const std::size_t narrow = hand.joints.size(), wide = kMountColumns + narrow;
  if (names.size() != narrow && names.size() != wide) {
    throw BadInput(
        fmt::format("{}:1: {} columns; waypoints have the {} joints ({} ... {}), or {} with {}",
                    source, names.size(), narrow, hand.joints.front().name, hand.joints.back().name,
                    wide, fmt::join(kMountNames, ",")));
  }
  std::vector<std::size_t> columns;
  for (std::string_view name : names) {
    columns.push_back(column_index(hand, name, source));
    const bool again = std::count(columns.begin(), columns.end(), columns.back()) > 1;
    const bool unexpected = names.size() == narrow && columns.back() < kMountColumns;
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
      waypoint.mount.xyz[k] = value;
    } else if (k < 6) {
      waypoint.mount.ypr[k - 3] = value;
    } else {
      waypoint.joints[k - 6] = value;
    }
  }
  return waypoint;
}

}  // namespace

hand::HandCommand command_of(const Waypoint& waypoint, const hand::Description& hand) {
  return {.positions = hand::actuator_positions(hand, waypoint.joints), .mount = waypoint.mount};
}

WaypointsFile parse_waypoints(std::string_view text, std::string_view source,
                              const hand::MountPosition& mount, const hand::Description& hand) {
  CsvTable table(text, std::string(source));
  const std::size_t first = table.names().front() == kTime ? 1 : 0;
  const auto columns = parse_header(hand, std::span(table.names()).subspan(first), source);
  WaypointsFile file;
  const Waypoint still{.mount = mount, .joints = hand::JointVector::Zero(hand.joint_count())};
  while (table.next()) file.waypoints.push_back(parse_row(table, first, columns, still));
  if (file.waypoints.size() < 2) {
    throw BadInput(fmt::format("{}: a path needs at least two waypoints, not {}", source,
                               file.waypoints.size()));
  }
  file.has_mount = columns.size() > hand.joints.size();
  return file;
}

}  // namespace palpate::planning
