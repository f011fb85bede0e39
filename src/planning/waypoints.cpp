// SPDX-License-Identifier: Apache-2.0
#include "palpate/planning/waypoints.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <charconv>
#include <cmath>

#include "palpate/core/csv.hpp"
#include "palpate/core/error.hpp"
#include "palpate/hand/joints.hpp"

namespace palpate::planning {
namespace {

constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";
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

std::vector<std::string_view> cells_without_time(std::string_view line, bool timed) {
  auto cells = csv_cells(line);
  if (timed && !cells.empty()) cells.erase(cells.begin());
  return cells;
}

std::vector<std::size_t> parse_header(std::string_view line, bool timed, std::string_view source) {
  const auto names = cells_without_time(line, timed);
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

double parse_number(std::string_view cell, std::string_view where, std::size_t column) {
  double value = 0;
  const auto [end, error] = std::from_chars(cell.data(), cell.data() + cell.size(), value);
  if (error == std::errc() && end == cell.data() + cell.size() && std::isfinite(value)) {
    return value;
  }
  throw BadInput(fmt::format(
      "{}: '{}' in column {} is not a finite number", where, cell,
      column < kBaseColumns ? kBaseNames[column] : hand::kJointNames[column - kBaseColumns]));
}

Waypoint parse_row(std::string_view line, bool timed, const std::vector<std::size_t>& columns,
                   const std::string& where, Waypoint waypoint) {
  const auto cells = cells_without_time(line, timed);
  if (cells.size() != columns.size()) {
    throw BadInput(
        fmt::format("{}: {} values for {} columns", where, cells.size(), columns.size()));
  }
  for (std::size_t i = 0; i < cells.size(); ++i) {
    const double value = parse_number(cells[i], where, columns[i]);
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
  if (text.starts_with(kByteOrderMark)) text.remove_prefix(kByteOrderMark.size());
  std::vector<std::size_t> columns;
  bool timed = false;
  WaypointsFile file;
  for (std::size_t number = 1; !text.empty(); ++number) {
    const auto end = std::min(text.find('\n'), text.size());
    const std::string_view line = trimmed(text.substr(0, end));
    text.remove_prefix(std::min(end + 1, text.size()));
    if (line.empty()) continue;
    if (columns.empty()) {
      timed = csv_cells(line).front() == kTime;
      columns = parse_header(line, timed, source);
    } else {
      file.waypoints.push_back(
          parse_row(line, timed, columns, fmt::format("{}:{}", source, number), {.base = base}));
    }
  }
  if (file.waypoints.size() < 2) {
    throw BadInput(fmt::format("{}: a path needs at least two waypoints, not {}", source,
                               file.waypoints.size()));
  }
  file.has_base = columns.size() > hand::kJoints;
  return file;
}

}  // namespace palpate::planning
