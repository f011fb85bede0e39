// SPDX-License-Identifier: Apache-2.0
#include "palpate/evaluation/start.hpp"

#include <gtest/gtest.h>

#include "palpate/core/error.hpp"
#include "palpate/hand/shadow.hpp"
#include "simulation/fine_meshes.hpp"

namespace palpate::evaluation {
namespace {

double beyond(const simulation::World& world, const StartOptions& options) {
  const Eigen::Vector3d at = world.truth().T_world_object.translation();
  return at.head<2>().cwiseAbs().maxCoeff() - options.uncertainty;
}

TEST(Start, IsDrawnWithinItsBoundsByTheSeed) {
  const auto box = geometry::load_known_object("box");
  StartOptions options;
  options.stable_pose = 1;
  options.uncertainty = 0.01;
  Eigen::Vector2d previous(1, 1);
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    const auto start = draw_start(box, options, seed);
    EXPECT_EQ(start.stable_pose, 1);
    EXPECT_LE(start.xy.cwiseAbs().maxCoeff(), 0.01);
    EXPECT_NE(start.xy, previous);
    EXPECT_EQ(start.xy, draw_start(box, options, seed).xy);
    previous = start.xy;
  }
  options.stable_pose = static_cast<int>(box.stable_poses.size());
  EXPECT_THROW(draw_start(box, options, 0), BadInput);
}

/// A hand that is closed at 0 would wait with its fingers hooked into one another.
TEST(Start, TheHandWaitsStraight) {
  hand::Description hand = hand::shadow_hand();
  const int bends = hand.actuator("FFJ3"), closes_to_zero = hand.actuator("MFJ3");
  hand.actuators[static_cast<std::size_t>(closes_to_zero)].closing = -1;
  hand.actuators[static_cast<std::size_t>(closes_to_zero)].command = {0, 1.5};
  const auto waiting = waiting_command(hand).positions;
  EXPECT_EQ(waiting[bends], 0);
  EXPECT_EQ(waiting[closes_to_zero], 1.5);
  hand.actuators[static_cast<std::size_t>(closes_to_zero)].command = {-0.03, 1.5};
  EXPECT_EQ(waiting_command(hand).positions[closes_to_zero], 1.5);
  hand.actuators[static_cast<std::size_t>(bends)].command = {0.2, 1.5};
  EXPECT_EQ(waiting_command(hand).positions[bends], 0.2);
}

/// The centre of mass of this ball is 10 mm from where it is believed to be.
TEST(Start, IsOneFromWhichTheObjectDoesNotRollAway) {
  const auto object = geometry::make_known_object("ball", simulation::bumpy_ball(2000), 0.2);
  StartOptions options;
  simulation::WorldOptions unbalanced;
  unbalanced.error.center = 0.01;
  int rolled = 0;
  for (std::uint64_t seed = 1; seed <= 6; ++seed) {
    simulation::World world(object, unbalanced, seed);
    const auto waiting = waiting_command(world.hand_model());
    const auto first = draw_start(object, options, seed);
    const auto place = world.resting_place(first, waiting);
    const bool rolls = !place || place->cwiseAbs().maxCoeff() > options.uncertainty + kPlaceMargin;
    rolled += rolls;
    const auto start = start_trial(world, object, options, seed);
    EXPECT_EQ(start.xy != first.xy, rolls) << seed;
    for (int tick = 0; tick < 500; ++tick) world.hand().step(waiting);
    EXPECT_LE(beyond(world, options), kPlaceMargin + 1e-3) << seed;
  }
  EXPECT_GT(rolled, 0);
  EXPECT_LT(rolled, 6);
}

/// Readings are then those of a world that was reset once.
TEST(Start, LeavesNoTraceInTheWorld) {
  const auto object = geometry::load_known_object("box");
  const StartOptions options;
  simulation::World one(object, simulation::WorldOptions::realistic(), 3);
  simulation::World other(object, simulation::WorldOptions::realistic(), 3);
  const auto waiting = waiting_command(one.hand_model());
  one.reset(draw_start(object, options, 3), waiting);
  start_trial(other, object, options, 3);
  for (int tick = 0; tick < 5; ++tick) {
    const auto a = one.hand().step(waiting);
    const auto b = other.hand().step(waiting);
    EXPECT_EQ(a.time, b.time);
    EXPECT_EQ(a.joints, b.joints);
    EXPECT_EQ(a.mount_force, b.mount_force);
  }
}

}  // namespace
}  // namespace palpate::evaluation
