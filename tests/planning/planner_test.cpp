// SPDX-License-Identifier: Apache-2.0
#include "palpate/planning/planner.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "palpate/core/error.hpp"
#include "palpate/simulation/collision/collision_scene.hpp"
#include "planning/motions.hpp"

namespace palpate::planning {
namespace {

constexpr std::uint64_t kSeed = 5;

/// The plate on the table between the hand's start and its goal.
simulation::CollisionScene blocked_scene() {
  simulation::CollisionScene scene(plate(), drawn_hand());
  scene.place(at(0, 0, 0.08));
  return scene;
}
const std::vector<Waypoint> kAcross = {open_hand(0, -0.25, 0.12), open_hand(0, 0.25, 0.12)};

void expect_free(simulation::CollisionScene& scene, const Plan& plan) {
  for (std::size_t i = 0; i < plan.samples.size(); ++i) {
    ASSERT_TRUE(is_free(scene, plan.samples[i])) << "sample " << i;
  }
}

void expect_within_limits(const Plan& plan, const MotionLimits& limits) {
  const auto rows = coordinates(plan.samples);
  const Coordinates speed = speed_limits(limits, rows.front().size()),
                    acceleration = acceleration_limits(limits, rows.front().size());
  for (std::size_t i = 1; i + 1 < rows.size(); ++i) {
    const Coordinates v = (rows[i + 1] - rows[i]) / hand::kTick;
    const Coordinates a = (rows[i + 1] - 2 * rows[i] + rows[i - 1]) / (hand::kTick * hand::kTick);
    ASSERT_LE(v.cwiseAbs().cwiseQuotient(speed).maxCoeff(), 1 + 1e-6) << i;
    ASSERT_LE(a.cwiseAbs().cwiseQuotient(acceleration).maxCoeff(), 1 + 1e-6) << i;
  }
}

TEST(Plan, GoesStraightWhereNothingIsInTheWay) {
  simulation::CollisionScene scene(drawn_hand());
  const auto result = plan({open_hand(-0.2, 0, 0.2), open_hand(0.2, 0, 0.2)}, scene, {}, kSeed);
  ASSERT_EQ(result.status, PlanStatus::ok);
  EXPECT_EQ(result.corners.size(), 2U);
  EXPECT_GT(result.duration(), 0.4 / 0.25);
}

TEST(Plan, GoesAroundTheObject) {
  auto scene = blocked_scene();
  const auto result = plan(kAcross, scene, {}, kSeed);
  ASSERT_EQ(result.status, PlanStatus::ok);
  EXPECT_GT(result.corners.size(), 2U);
  expect_free(scene, result);
  expect_within_limits(result, {});
  const auto rows = coordinates(result.samples);
  EXPECT_EQ(rows.front(), coordinates_of(command_of(kAcross.front(), hand::shadow_hand())));
  EXPECT_EQ(rows.back(), coordinates_of(command_of(kAcross.back(), hand::shadow_hand())));
}

TEST(Plan, EveryPlannerFindsTheWay) {
  for (const char* planner : {"rrt-connect", "rrt-star", "prm", "fmt"}) {
    auto scene = blocked_scene();
    PlanOptions options;
    options.planner = planner;
    const auto result = plan(kAcross, scene, options, kSeed);
    ASSERT_EQ(result.status, PlanStatus::ok) << planner;
    expect_free(scene, result);
  }
}

TEST(Plan, TheSeedAloneDecides) {
  for (const char* planner : {"rrt-connect", "prm"}) {
    PlanOptions options;
    options.planner = planner;
    const auto once = [&](std::uint64_t seed) {
      auto scene = blocked_scene();
      return coordinates(plan(kAcross, scene, options, seed).samples);
    };
    const auto first = once(kSeed);
    EXPECT_EQ(first, once(kSeed)) << planner;
    EXPECT_NE(first, once(kSeed + 1)) << planner;
  }
}

TEST(Plan, PassesEveryWaypointAtRest) {
  simulation::CollisionScene scene(drawn_hand());
  std::vector<Waypoint> waypoints(5, open_hand(0, 0, 0.3));
  for (std::size_t i = 1; i < waypoints.size(); ++i) {
    joint(waypoints[i], "FFJ3") = 0.3 * static_cast<double>(i % 3);
    joint(waypoints[i], "FFJ2") = 0.2 * static_cast<double>(i);
  }
  waypoints[4] = waypoints[3];  // one that is there already
  const auto result = plan(waypoints, scene, {}, kSeed);
  ASSERT_EQ(result.status, PlanStatus::ok);
  ASSERT_EQ(result.arrivals.size(), waypoints.size());
  for (std::size_t i = 0; i < waypoints.size(); ++i) {
    EXPECT_EQ(coordinates_of(result.samples[result.arrivals[i]]),
              coordinates_of(command_of(waypoints[i], hand::shadow_hand())));
  }
  EXPECT_EQ(result.arrivals[4], result.arrivals[3]);
  expect_within_limits(result, {});
  for (const Coordinates& row : coordinates(result.samples)) {
    EXPECT_EQ(row.head<6>(),
              coordinates_of(command_of(waypoints[0], hand::shadow_hand())).head<6>());
  }
}

TEST(Plan, WaypointsThatDifferByRoundingAreThePlaceWhereItIsAlready) {
  simulation::CollisionScene scene(drawn_hand());
  std::vector<Waypoint> waypoints(5, open_hand(0, 0, 0.3));
  joint(waypoints[0], "FFJ2") = 0.3;
  joint(waypoints[1], "FFJ2") = 0.2, joint(waypoints[1], "FFJ1") = 0.1;  // 0.1 + 0.2 is not 0.3
  waypoints[2] = waypoints[3] = waypoints[4] = waypoints[1];
  waypoints[3].mount.xyz.x() = 1e-10;
  waypoints[4].mount.xyz.x() = 0.1;
  ASSERT_NE(coordinates_of(command_of(waypoints[0], drawn_hand())),
            coordinates_of(command_of(waypoints[1], drawn_hand())));
  const auto still = plan({waypoints[0], waypoints[1]}, scene, {}, kSeed);
  ASSERT_EQ(still.status, PlanStatus::ok);
  EXPECT_EQ(still.samples.size(), 1U);
  EXPECT_EQ(still.arrivals, (std::vector<std::size_t>{0, 0}));
  const auto result = plan(waypoints, scene, {}, kSeed);
  ASSERT_EQ(result.status, PlanStatus::ok);
  ASSERT_EQ(result.arrivals.size(), waypoints.size());
  EXPECT_EQ(result.arrivals[3], 0U);
  EXPECT_EQ(coordinates_of(result.samples.back()),
            coordinates_of(command_of(waypoints[4], drawn_hand())));
  expect_within_limits(result, {});
}

/// One finger leans over its neighbour: to change places it must lean back, which neither waypoint
/// shows.
TEST(Plan, FingersGoAroundEachOther) {
  simulation::CollisionScene scene(drawn_hand());
  Waypoint start = open_hand(0, 0, 0.3), goal = start;
  for (Waypoint* waypoint : {&start, &goal}) joint(*waypoint, "FFJ4") = 0.3;
  joint(start, "MFJ3") = 1.3;
  joint(goal, "FFJ3") = 1.3;
  const auto result = plan({start, goal}, scene, {}, kSeed);
  ASSERT_EQ(result.status, PlanStatus::ok)
      << (result.invalid.empty() ? "" : result.invalid[0].reason);
  EXPECT_GT(result.corners.size(), 2U);
  expect_free(scene, result);
  expect_within_limits(result, {});
}

/// The plate hangs below the palm: it would drag over a table that the empty hand clears.
TEST(Plan, KeepsAHeldObjectOffTheTable) {
  simulation::CollisionScene scene(plate(), drawn_hand());
  const Waypoint high = open_hand(0, 0, 0.3), low = open_hand(0.2, 0, 0.05);
  const Eigen::Isometry3d T_world_palm = scene.palm_pose(high.mount, high.joints);
  scene.hold(T_world_palm.inverse() * at(0, 0, 0.2));
  const auto result = plan({high, low}, scene, {}, kSeed);
  ASSERT_EQ(result.status, PlanStatus::invalid);
  ASSERT_EQ(result.invalid.size(), 1U);
  EXPECT_EQ(result.invalid[0].waypoint, 1U);
  EXPECT_NE(result.invalid[0].reason.find("object"), std::string::npos);
  EXPECT_NE(result.invalid[0].reason.find("table"), std::string::npos);
  const auto free = plan({high, open_hand(0.2, 0, 0.2)}, scene, {}, kSeed);
  EXPECT_EQ(free.status, PlanStatus::ok);
  expect_free(scene, free);
}

/// A hand that may only move in y cannot pass the plate.
TEST(Plan, SaysWhichWaypointCannotBeReached) {
  auto scene = blocked_scene();
  PlanOptions options;
  options.iterations = 200;
  options.detour = 0;
  const auto result = plan({open_hand(0, -0.25, 0.12), open_hand(0, -0.2, 0.12), kAcross.back()},
                           scene, options, kSeed);
  EXPECT_EQ(result.status, PlanStatus::no_path);
  EXPECT_EQ(result.unreachable, 2U);
  EXPECT_TRUE(result.samples.empty());
}

TEST(Plan, BadInput) {
  simulation::CollisionScene scene(drawn_hand());
  EXPECT_THROW(plan({open_hand(0, 0, 0.3)}, scene, {}, kSeed), BadInput);
  PlanOptions options;
  options.planner = "a-star";
  EXPECT_THROW(plan(kAcross, scene, options, kSeed), BadInput);
}

}  // namespace
}  // namespace palpate::planning
