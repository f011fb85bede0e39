// SPDX-License-Identifier: Apache-2.0
#include "palpate/planning/planner.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <numeric>
#include <utility>

#include "palpate/core/error.hpp"
#include "palpate/core/random.hpp"
#include "planning/search.hpp"

namespace palpate::planning {
namespace {

constexpr std::array<std::pair<std::string_view, PlannerKind>, 4> kPlanners = {
    {{"rrt-connect", PlannerKind::rrt_connect},
     {"rrt-star", PlannerKind::rrt_star},
     {"prm", PlannerKind::prm},
     {"fmt", PlannerKind::fmt}}};

constexpr int kRefinements = 3;      // of the step, where a sample between two checks collides
constexpr double kMinCut = 1e-3;     // m of path; a corner that cannot be cut by as much is kept
constexpr double kSamePlace = 1e-9;  // m of path: no motion, but rounding

/// Range of a coordinate by the hand's actuators and the mount's options.
hand::Range range_of(int coordinate, const MountRange& mount, const hand::Description& hand) {
  if (coordinate < 2) return {-mount.side, mount.side};
  if (coordinate == 2) return {mount.low, mount.high};
  if (coordinate < kMountCoordinates) return {-mount.turn, mount.turn};
  return hand.actuators[static_cast<std::size_t>(coordinate - kMountCoordinates)].command;
}

/// Plans the ways from each waypoint to the next.
class LegPlanner {
 public:
  LegPlanner(const std::vector<Coordinates>& waypoints, CollisionChecker& scene,
             const PlanOptions& options, std::uint64_t seed)
      : options_(options),
        hand_(scene.hand()),
        planner_(planner_named(options.planner)),
        free_(scene, options.step),
        random_(seed, "plan") {
    for (const Coordinates& waypoint : waypoints) {
      mount_moves_ = mount_moves_ || waypoint.head<6>() != waypoints.front().head<6>();
    }
  }

  /// Vertices of a free polyline; empty if none was found.
  std::vector<Coordinates> find(const Coordinates& start, const Coordinates& goal);
  /// The polyline's motion, one sample a tick; empty if a sample collides.
  std::vector<Coordinates> move_along(const std::vector<Coordinates>& corners);
  void look_closer() { free_.halve_step(); }
  [[nodiscard]] int checks() const { return free_.checks(); }

 private:
  [[nodiscard]] std::vector<int> differing(const Coordinates& start, const Coordinates& goal) const;
  [[nodiscard]] std::vector<int> movable() const;
  [[nodiscard]] SearchSpace space(std::vector<int> moving, const Coordinates& start,
                                  const Coordinates& goal) const;
  [[nodiscard]] std::vector<double> cuts(const std::vector<Coordinates>& corners);

  PlanOptions options_;
  const hand::Description& hand_;
  PlannerKind planner_;
  HandSpace free_;
  RandomStream random_;
  bool mount_moves_ = false;
};

std::vector<int> LegPlanner::movable() const {
  std::vector<int> all(hand_.actuators.size() + (mount_moves_ ? kMountCoordinates : 0));
  std::iota(all.begin(), all.end(), mount_moves_ ? 0 : kMountCoordinates);
  return all;
}

/// What differs, and the whole mount if any of it does.
std::vector<int> LegPlanner::differing(const Coordinates& start, const Coordinates& goal) const {
  std::vector<int> result;
  for (int k : movable()) {
    if (k < 6 || start[k] != goal[k]) result.push_back(k);
  }
  return result;
}

SearchSpace LegPlanner::space(std::vector<int> moving, const Coordinates& start,
                              const Coordinates& goal) const {
  SearchSpace result{.moving = std::move(moving), .low = start, .high = start};
  for (int k : result.moving) {
    const hand::Range range = range_of(k, options_.mount, hand_);
    const double beyond = k < 6 ? options_.detour : range.high - range.low;
    result.low[k] = std::max(range.low, std::min(start[k], goal[k]) - beyond);
    result.high[k] = std::min(range.high, std::max(start[k], goal[k]) + beyond);
  }
  return result;
}

std::vector<Coordinates> LegPlanner::find(const Coordinates& start, const Coordinates& goal) {
  if (distance(start, goal, free_.metric()) <= kSamePlace) return {goal};
  if (free_.holds_line(start, goal)) return {start, goal};
  const PathSearchOptions search_options{.planner = planner_,
                                         .iterations = std::max(1, options_.iterations / 2),
                                         .shortenings = options_.shortenings};
  std::vector<std::vector<int>> spaces = {differing(start, goal)};
  if (options_.move_all) spaces.push_back(movable());
  for (std::vector<int>& moving : spaces) {
    auto corners = search(start, goal, free_, space(std::move(moving), start, goal), search_options,
                          random_.bits());
    if (corners.empty()) continue;
    corners.front() = start, corners.back() = goal;
    return corners;
  }
  return {};
}

/// How far from each corner it can be cut without a collision.
std::vector<double> LegPlanner::cuts(const std::vector<Coordinates>& corners) {
  std::vector<double> result(corners.size(), 0.0);
  for (std::size_t i = 1; i + 1 < corners.size(); ++i) {
    const Coordinates& metric = free_.metric();
    const double most = 0.5 * std::min(distance(corners[i - 1], corners[i], metric),
                                       distance(corners[i], corners[i + 1], metric));
    for (double cut = std::min(options_.rounding, most); cut >= kMinCut; cut *= 0.5) {
      const auto cut_corner = rounded({corners.begin() + static_cast<std::ptrdiff_t>(i) - 1,
                                       corners.begin() + static_cast<std::ptrdiff_t>(i) + 2},
                                      {0, cut, 0}, metric);
      if (!std::all_of(cut_corner.begin(), cut_corner.end(),
                       [&](const PathPiece& piece) { return free_.holds_piece(piece); })) {
        continue;
      }
      result[i] = cut;
      break;
    }
  }
  return result;
}

std::vector<Coordinates> LegPlanner::move_along(const std::vector<Coordinates>& corners) {
  if (corners.size() < 2) return corners;
  std::vector<Coordinates> samples =
      time_path(rounded(corners, cuts(corners), free_.metric()), options_.limits, free_.metric());
  if (samples.empty()) return {corners.back()};  // all of it is too short to be a motion
  samples.back() = corners.back();
  const bool free = std::all_of(samples.begin(), samples.end(),
                                [&](const Coordinates& sample) { return free_.holds(sample); });
  return free ? samples : std::vector<Coordinates>{};
}

/// Appends the leg to the plan. @return whether there is one
bool add_leg(const Coordinates& start, const Coordinates& goal, LegPlanner& legs, Plan& plan) {
  for (int refinement = 0; refinement <= kRefinements; ++refinement) {
    if (refinement > 0) legs.look_closer();
    const std::vector<Coordinates> corners = legs.find(start, goal);
    if (corners.empty()) return false;
    const std::vector<Coordinates> samples = legs.move_along(corners);
    if (samples.empty()) continue;
    for (std::size_t i = 1; i < corners.size(); ++i) plan.corners.push_back(command_of(corners[i]));
    for (std::size_t i = 1; i < samples.size(); ++i) plan.samples.push_back(command_of(samples[i]));
    plan.arrivals.push_back(plan.samples.size() - 1);
    return true;
  }
  return false;
}

void add_legs(const std::vector<Coordinates>& waypoints, LegPlanner& legs, Plan& plan) {
  const hand::HandCommand start = command_of(waypoints.front());
  plan.corners = {start}, plan.samples = {start}, plan.arrivals = {0};
  for (std::size_t i = 1; i < waypoints.size(); ++i) {
    if (add_leg(waypoints[i - 1], waypoints[i], legs, plan)) continue;
    plan.status = PlanStatus::no_path;
    plan.unreachable = i;
    plan.corners.clear(), plan.samples.clear(), plan.arrivals.clear();
    return;
  }
}

}  // namespace

PlannerKind planner_named(std::string_view name) {
  for (const auto& [known, kind] : kPlanners) {
    if (known == name) return kind;
  }
  throw BadInput(
      fmt::format("no planner is named '{}'; there are rrt-connect, rrt-star, prm, fmt", name));
}

std::string_view to_string(PlanStatus status) {
  switch (status) {
    case PlanStatus::ok:
      return "ok";
    case PlanStatus::invalid:
      return "invalid";
    case PlanStatus::no_path:
      break;
  }
  return "no_path";
}

Plan plan(const std::vector<Waypoint>& waypoints, CollisionChecker& scene,
          const PlanOptions& options, std::uint64_t seed) {
  if (waypoints.size() < 2) {
    throw BadInput(fmt::format("a path needs at least two waypoints, not {}", waypoints.size()));
  }
  const auto began = std::chrono::steady_clock::now();
  Plan result;
  result.invalid = find_invalid_waypoints(waypoints, scene, options.mount);
  std::vector<Coordinates> coordinates;
  for (const Waypoint& waypoint : waypoints) {
    coordinates.push_back(coordinates_of(command_of(waypoint, scene.hand())));
  }
  LegPlanner legs(coordinates, scene, options, seed);
  if (result.invalid.empty()) {
    add_legs(coordinates, legs, result);
  } else {
    result.status = PlanStatus::invalid;
  }
  result.checks = legs.checks();
  result.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - began).count();
  return result;
}

}  // namespace palpate::planning
