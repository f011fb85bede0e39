// SPDX-License-Identifier: Apache-2.0
#include "plan_report.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <numeric>

#include "palpate/hand/kinematics.hpp"
#include "palpate/plotting/plot.hpp"

namespace palpate::app {
namespace {

namespace pl = planning;

nlohmann::json tracking_json(const pl::TrackingError& error) {
  return {{"joint_rms", error.joint_rms}, {"joint_max", error.joint_max},
          {"mount_rms", error.mount_rms}, {"mount_max", error.mount_max},
          {"turn_rms", error.turn_rms},   {"turn_max", error.turn_max}};
}

std::string_view name_of(int coordinate, const hand::Description& hand) {
  const auto k = static_cast<std::size_t>(coordinate);
  constexpr std::size_t kMount = pl::kMountCoordinates;
  return k < kMount ? pl::kMountNames[k] : hand.actuators[k - kMount].name;
}

/// Coordinates by how much they move, the most first; those at rest are left out.
std::vector<int> moving(const std::vector<pl::Coordinates>& rows) {
  pl::Coordinates low = rows.front(), high = rows.front();
  for (const auto& row : rows) low = low.cwiseMin(row), high = high.cwiseMax(row);
  std::vector<int> order(static_cast<std::size_t>(low.size()));
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(),
                   [&](int a, int b) { return high[a] - low[a] > high[b] - low[b]; });
  std::erase_if(order, [&](int k) { return !(high[k] > low[k]); });
  return order;
}

plotting::LineSeries series(const std::string& name, const std::vector<pl::Coordinates>& rows,
                            int k) {
  plotting::LineSeries line{.name = name, .x = {}, .y = {}};
  for (std::size_t i = 0; i < rows.size(); ++i) {
    line.x.push_back(static_cast<double>(i) * hand::kTick);
    line.y.push_back(rows[i][k]);
  }
  return line;
}

}  // namespace

nlohmann::json plan_report(const pl::Plan& plan, const std::optional<pl::TrackingError>& tracking) {
  auto invalid = nlohmann::json::array();
  for (const pl::InvalidWaypoint& fault : plan.invalid) {
    invalid.push_back({{"waypoint", fault.waypoint}, {"reason", fault.reason}});
  }
  nlohmann::json report = {{"status", pl::to_string(plan.status)},
                           {"invalid", invalid},
                           {"duration", plan.duration()},
                           {"samples", plan.samples.size()},
                           {"arrivals", plan.arrivals},
                           {"corners", plan.corners.size()},
                           {"checks", plan.checks},
                           {"planning_seconds", plan.seconds}};
  if (plan.status == pl::PlanStatus::no_path) report["unreachable"] = plan.unreachable;
  if (tracking) report["tracking"] = tracking_json(*tracking);
  return report;
}

std::string describe_invalid(const std::vector<pl::InvalidWaypoint>& invalid) {
  constexpr std::size_t kShown = 3;
  std::vector<std::string> lines;
  for (std::size_t i = 0; i < std::min(kShown, invalid.size()); ++i) {
    lines.push_back(fmt::format("waypoint {}: {}", invalid[i].waypoint, invalid[i].reason));
  }
  if (invalid.size() > kShown) lines.push_back(fmt::format("and {} more", invalid.size() - kShown));
  return fmt::format("{}", fmt::join(lines, "; "));
}

std::string path_csv(const std::vector<hand::HandCommand>& samples, const hand::Description& hand) {
  std::string text = fmt::format("t_s,{}", fmt::join(pl::kMountNames, ","));
  for (const hand::Joint& joint : hand.joints) text += "," + joint.name;
  text += "\n";
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const auto& [positions, mount] = samples[i];
    text += fmt::format("{:.2f},{},{},{}\n", static_cast<double>(i) * hand::kTick,
                        fmt::join(mount.xyz, ","), fmt::join(mount.ypr, ","),
                        fmt::join(hand::joints_in_free_flexion(hand, positions), ","));
  }
  return text;
}

std::string plot_motion(const pl::Plan& plan, const std::optional<pl::TrackingError>& tracking,
                        const hand::Description& hand) {
  constexpr std::size_t kLines = 6;
  std::vector<pl::Coordinates> rows;
  for (const auto& sample : plan.samples) rows.push_back(pl::coordinates_of(sample));
  auto shown = moving(rows);
  if (shown.empty()) shown = {0};
  shown.resize(std::min(shown.size(), tracking ? kLines / 2 : kLines));
  plotting::Plot plot;
  plot.title = "Planned motion";
  plot.x.label = "time (s)";
  plot.y.label = "position (m, rad)";
  for (int k : shown) {
    plot.series.emplace_back(series(std::string(name_of(k, hand)), rows, k));
    if (!tracking) continue;
    plot.series.emplace_back(
        series(fmt::format("{} measured", name_of(k, hand)), tracking->measured, k));
  }
  return plotting::to_svg(plot);
}

}  // namespace palpate::app
