// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>

#include "experiment.hpp"
#include "palpate/core/random.hpp"
#include "palpate/core/statistics.hpp"
#include "palpate/hand/kinematics.hpp"
#include "palpate/hand/shadow.hpp"
#include "palpate/planning/planner.hpp"
#include "palpate/plotting/plot.hpp"
#include "palpate/simulation/collision/collision_scene.hpp"
#include "palpate/simulation/hand/load_hand.hpp"

namespace {

using namespace palpate;
namespace pl = planning;

constexpr int kQueries = 60;  // an object
constexpr int kQuickQueries = 2;
constexpr double kTarget = 0.2;  // s, median a motion

/// Where the start and the goal of a query are.
enum class Kind { anywhere, blocked };

/// What a planner did with the queries of one object.
struct Tally {
  int queries = 0, found = 0, detours = 0, sound = 0;
  std::vector<double> seconds, durations;
};

/// A posture between open and a loose fist, in reach of the object and free.
pl::Waypoint random_waypoint(RandomStream& random, simulation::CollisionScene& scene) {
  for (;;) {
    pl::Waypoint waypoint;
    waypoint.joints.setZero(hand::kShadowJoints);
    waypoint.mount.xyz << random.uniform(-0.3, 0.3), random.uniform(-0.3, 0.3),
        random.uniform(0.05, 0.35);
    waypoint.mount.ypr << random.uniform(-1.5, 1.5), random.uniform(-0.6, 0.6),
        random.uniform(-1.5, 1.5);
    const double bend = random.uniform();
    for (int i = 0; i < hand::kShadowJoints; ++i) {
      const hand::Range range = scene.hand().joints[static_cast<std::size_t>(i)].range;
      const bool flexes = range.high > 1.5;
      waypoint.joints[i] =
          flexes ? bend * random.uniform(0, 1.2) : 0.3 * random.uniform(range.low, range.high);
    }
    waypoint.joints = hand::joints_in_free_flexion(
        scene.hand(), pl::command_of(waypoint, scene.hand()).positions);
    if (pl::find_invalid_waypoints({waypoint}, scene).empty()) return waypoint;
  }
}

bool is_blocked(const pl::Waypoint& start, const pl::Waypoint& goal,
                simulation::CollisionScene& scene) {
  constexpr int kSteps = 100;
  const pl::Coordinates a = pl::coordinates_of(pl::command_of(start, scene.hand()));
  const pl::Coordinates b = pl::coordinates_of(pl::command_of(goal, scene.hand()));
  for (int i = 1; i < kSteps; ++i) {
    const hand::HandCommand command = pl::command_of(pl::Coordinates(a + i * (b - a) / kSteps));
    if (scene.deepest_collision(command.mount,
                                hand::joints_in_free_flexion(scene.hand(), command.positions))) {
      return true;
    }
  }
  return false;
}

std::vector<pl::Waypoint> random_query(Kind kind, RandomStream& random,
                                       simulation::CollisionScene& scene) {
  for (;;) {
    const pl::Waypoint start = random_waypoint(random, scene);
    const pl::Waypoint goal = random_waypoint(random, scene);
    if (kind == Kind::anywhere || is_blocked(start, goal, scene)) return {start, goal};
  }
}

/// Whether a plan does what it says: every sample is free.
bool is_sound(const pl::Plan& plan, simulation::CollisionScene& scene) {
  return std::all_of(plan.samples.begin(), plan.samples.end(), [&](const auto& sample) {
    return !scene.deepest_collision(sample.mount,
                                    hand::joints_in_free_flexion(scene.hand(), sample.positions));
  });
}

simulation::CollisionScene scene_with(const std::string& name, RandomStream random) {
  const geometry::KnownObject object = geometry::load_known_object(name);
  simulation::CollisionScene scene(object, simulation::load_hand("shadow"));
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.rotate(Eigen::AngleAxisd(random.uniform(-3.14, 3.14), Eigen::Vector3d::UnitZ()));
  T.rotate(object.stable_poses.front().R_table_object);
  T.translation().z() = object.stable_poses.front().height;
  scene.place(T);
  return scene;
}

Tally ask(const std::string& object, Kind kind, const pl::PlanOptions& options, int queries,
          std::uint64_t seed) {
  const RandomStream random =
      RandomStream(seed, "planning_queries").fork(kind == Kind::blocked ? "blocked" : "anywhere");
  auto scene = scene_with(object, random.fork(object));
  Tally tally;
  for (int i = 0; i < queries; ++i) {
    const auto number = static_cast<std::uint64_t>(i);
    RandomStream query = random.fork(object, number);
    const auto waypoints = random_query(kind, query, scene);
    const pl::Plan plan = pl::plan(waypoints, scene, options, seed + number);
    ++tally.queries;
    tally.seconds.push_back(plan.seconds);
    if (plan.status != pl::PlanStatus::ok) continue;
    ++tally.found;
    tally.sound += is_sound(plan, scene) ? 1 : 0;
    tally.detours += plan.corners.size() > 2 ? 1 : 0;
    tally.durations.push_back(plan.duration());
  }
  return tally;
}

std::string milliseconds(const std::vector<double>& seconds, double share) {
  return seconds.empty() ? "-" : fmt::format("{:.0f}", 1e3 * quantile(seconds, share));
}

void add_row(experiment::Table& table, const std::string& planner, const std::string& what,
             const Tally& tally) {
  const auto n = static_cast<std::size_t>(tally.queries);
  const Interval ci = wilson_interval(static_cast<std::size_t>(tally.found), n);
  table.add_row(
      {planner, what, std::to_string(n),
       fmt::format("{:.3f} ({:.3f} .. {:.3f})",
                   static_cast<double>(tally.found) / static_cast<double>(n), ci.low, ci.high),
       fmt::format("{}/{}", tally.sound, tally.found), std::to_string(tally.detours),
       milliseconds(tally.seconds, 0.5), milliseconds(tally.seconds, 0.95),
       tally.durations.empty() ? "-" : fmt::format("{:.2f}", median(tally.durations))});
}

void append(std::vector<double>& to, const std::vector<double>& from) {
  to.insert(to.end(), from.begin(), from.end());
}

void add(Tally& sum, const Tally& part) {
  sum.queries += part.queries, sum.found += part.found;
  sum.detours += part.detours, sum.sound += part.sound;
  append(sum.seconds, part.seconds);
  append(sum.durations, part.durations);
}

/// Queries about each of the objects; their sum is a row as well.
Tally ask_all(experiment::Table& table, const std::vector<std::string>& objects, Kind kind,
              const std::string& planner, int queries, std::uint64_t seed) {
  pl::PlanOptions options;
  options.planner = planner;
  const std::string where = kind == Kind::blocked ? "blocked" : "anywhere";
  Tally all;
  for (const std::string& object : objects) {
    const Tally tally = ask(object, kind, options, queries, seed);
    add_row(table, planner, fmt::format("{}, {}", object, where), tally);
    add(all, tally);
  }
  if (objects.size() > 1) add_row(table, planner, fmt::format("all, {}", where), all);
  return all;
}

void planning_queries(const experiment::Options& options) {
  const int queries = options.quick ? kQuickQueries : kQueries;
  const auto objects =
      options.quick ? std::vector<std::string>{"box"} : geometry::built_in_objects();
  const std::vector<std::string> columns = {
      "planner", "queries about", "queries", "found (95 % CI)",   "free of collision",
      "detours", "median ms",     "95 % ms", "median s of motion"};
  plotting::BoxSeries boxes{.name = "", .samples = {}};
  const std::vector<std::string> planners = {"rrt-connect", "prm", "fmt", "rrt-star"};
  experiment::Table table(columns), others(columns);
  ask_all(table, objects, Kind::anywhere, planners.front(), queries, options.seed);
  boxes.samples.push_back(
      ask_all(table, objects, Kind::blocked, planners.front(), queries, options.seed).seconds);
  table.publish(
      options, "queries",
      fmt::format("Random motions about an object (target: found >= .99, median <= {:.0f} "
                  "ms); blocked: those whose straight way collides",
                  1e3 * kTarget));
  for (std::size_t i = 1; i < planners.size(); ++i) {
    const Tally tally =
        ask_all(others, {"box"}, Kind::blocked, planners[i], queries / 3 + 1, options.seed);
    boxes.samples.push_back(tally.seconds);
  }
  others.publish(options, "planners", "The other planners, about one object");
  plotting::Plot plot;
  plot.title = "Planning time of a motion around an obstacle";
  plot.x.label = "planner";
  plot.y = {.label = "time (s)", .logarithmic = true, .low = {}, .high = {}};
  plot.categories = planners;
  plot.series = {boxes};
  experiment::publish_figure(options, "seconds", plotting::to_svg(plot));
}

}  // namespace

int main(int argc, char** argv) {
  return experiment::run(argc, argv, "planning_queries",
                         "Success and time of planned motions between random postures about an "
                         "object on the table, by planner.",
                         planning_queries);
}
