// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "palpate/core/se3.hpp"
#include "simulation/fine_meshes.hpp"
#include "simulation/scenes.hpp"

namespace palpate::simulation {
namespace {

constexpr double kTurn = 0.1 * M_PI / 180;  // rad
constexpr double kWay = 1e-4;               // m

/// Expects that the object, left alone, settles within `tilt` rad of its stable pose and stays.
void expect_rest(const geometry::KnownObject& object, int pose, int ticks, double tilt) {
  World world(object, without_noise(), 1);
  const hand::HandCommand away = open_hand(0.6);
  world.reset({.stable_pose = pose, .yaw = 0.7}, away);
  const Eigen::Isometry3d start = world.truth().T_world_object;
  for (int tick = 0; tick < 50; ++tick) world.hand().step(away);
  const Eigen::Isometry3d settled = world.truth().T_world_object;
  EXPECT_LT(rotation_distance(start.linear(), settled.linear()), tilt) << object.name << pose;
  double turn = 0, way = 0;
  for (int tick = 0; tick < ticks; ++tick) {
    world.hand().step(away);
    const Eigen::Isometry3d now = world.truth().T_world_object;
    turn = std::max(turn, rotation_distance(settled.linear(), now.linear()));
    way = std::max(way, (now.translation() - settled.translation()).norm());
  }
  EXPECT_LT(turn, kTurn) << object.name << pose;
  EXPECT_LT(way, kWay) << object.name << pose;
  EXPECT_FALSE(world.diverged());
}

// It rests on points at its two ends, each among many vertices a fraction of a millimetre apart.
TEST(Resting, AFinelyTessellatedBananaStaysInEachOfItsStablePoses) {
  const auto banana = geometry::make_known_object("banana", bent_tube(1.2, 80, 48), 0.07);
  ASSERT_GE(banana.stable_poses.size(), 2u);
  for (const int pose : {0, 1}) expect_rest(banana, pose, 400, 0.01);
}

// A bumpy ball has a stable pose on every third bump or so; 0.1 mm decides whether it rolls on.
TEST(Resting, AFinelyTessellatedBumpyBallStays) {
  const auto ball = geometry::make_known_object("ball", bumpy_ball(6000), 0.1);
  for (const int pose : {0, 3}) expect_rest(ball, pose, 200, 0.02);
}

TEST(Resting, ALyingBottleStaysInItsStablePose) {
  const auto bottle = geometry::load_known_object("bottle");
  for (const int pose : {0, 1, 2}) expect_rest(bottle, pose, 200, 0.2 * M_PI / 180);
}

// A can of 128 sides reaches the table with more vertices than there is room for.
TEST(Resting, ARoundFootStandsUpright) {
  std::vector<Eigen::Vector2d> circle;
  for (int k = 0; k < 128; ++k) {
    const double angle = 2 * M_PI * k / 128;
    circle.emplace_back(0.03 * std::cos(angle), 0.03 * std::sin(angle));
  }
  const auto can = geometry::make_known_object("can", prism(circle, 0.05), 0.2);
  ASSERT_GE(can.stable_poses.size(), 3u);
  for (int pose = 0; pose < static_cast<int>(can.stable_poses.size()); ++pose) {
    expect_rest(can, pose, 100, 0.01);
  }
}

}  // namespace
}  // namespace palpate::simulation
