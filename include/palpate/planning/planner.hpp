// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "palpate/planning/trajectory.hpp"
#include "palpate/planning/waypoints.hpp"

namespace palpate::planning {

enum class PlannerKind { rrt_connect, rrt_star, prm, fmt };

/// @throws BadInput for a name other than rrt-connect, rrt-star, prm, fmt
PlannerKind planner_named(std::string_view name);

struct PlanOptions {
  std::string planner = "rrt-connect";  ///< rrt-connect, rrt-star, prm, fmt
  int iterations = 4000;                ///< of the search between two waypoints, in all
  int shortenings = 100;                ///< trials to cut a way short
  double step = 0.005;                  ///< m of path between checks for collision
  double detour = 0.25;                 ///< m, rad: search this far beyond start and goal
  double rounding = 0.03;               ///< m of path, how far from a corner it may be cut
  bool move_all = true;                 ///< what the waypoints keep, too, where nothing else helps
  MountRange mount;
  MotionLimits limits;

  template <class Visitor>
  void visit(Visitor&& v) {
    v("planner", planner, "planning algorithm: rrt-connect, rrt-star, prm or fmt");
    v("iterations", iterations, 1, 10000000,
      "iterations of the search between two waypoints at most");
    v("shortenings", shortenings, 0, 100000, "number of attempts to shorten the path");
    v("step", step, 1e-4, 0.05, "m, length of path between two collision checks");
    v("detour", detour, 0.0, 10.0, "m and rad, how far the search goes beyond start and goal");
    v("rounding", rounding, 0.0, 1.0,
      "m, distance from a corner within which the path may be rounded");
    v("move_all", move_all,
      "move what the waypoints keep constant, too, if there is no other path");
    v.section("mount", mount);
    v.section("limits", limits);
  }
};

enum class PlanStatus { ok, invalid, no_path };
std::string_view to_string(PlanStatus status);

struct Plan {
  PlanStatus status = PlanStatus::ok;
  std::vector<InvalidWaypoint> invalid;    ///< waypoints that cannot be taken
  std::size_t unreachable = 0;             ///< waypoint to which no path was found, of no_path
  std::vector<hand::HandCommand> corners;  ///< the path's vertices, all waypoints among them
  std::vector<hand::HandCommand> samples;  ///< one a tick of hand::kTick, from start to end
  std::vector<std::size_t> arrivals;       ///< sample at which each waypoint is reached, at rest
  int checks = 0;                          ///< configurations that were checked for collision
  double seconds = 0;                      ///< wall time

  [[nodiscard]] double duration() const {
    return samples.empty() ? 0 : static_cast<double>(samples.size() - 1) * hand::kTick;
  }
};

/// A collision-free motion of mount and hand through the waypoints (thesis section 2.2.1), at rest
/// in each, within the limits of speed and acceleration; every sample has been checked.
///
/// Sampling-based search with OMPL (Sucan et al., 2012) over the coordinates in which the waypoints
/// differ, and, where that finds no way and `move_all` allows it, over all that may move: the mount
/// only moves if waypoints differ in it. Bounded by iterations, not time: the same seed gives the
/// same plan. Plans of several threads wait for one another, for OMPL has one source of seeds.
/// @throws BadInput for fewer than two waypoints or an unknown planner
Plan plan(const std::vector<Waypoint>& waypoints, CollisionChecker& scene,
          const PlanOptions& options, std::uint64_t seed);

}  // namespace palpate::planning
