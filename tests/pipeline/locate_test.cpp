// SPDX-License-Identifier: Apache-2.0
#include "palpate/pipeline/locate.hpp"

#include <gtest/gtest.h>

#include "palpate/pipeline/trial.hpp"

namespace palpate::pipeline {
namespace {

/// A box that was picked quickly.
struct PickedBox {
  static constexpr std::uint64_t kSeed = 7;
  PickedBox() : object(geometry::load_known_object("box")) {
    TrialOptions options;
    options.pick.explore.touches = options.pick.explore.most_touches = 4;
    options.pick.lift.hold = 0.3;
    options.pick.locate.search.proposals = 20000;
    options.pick.locate.search.particles = 400;
    options.start.stance = 0;
    locate_options = options.pick.locate;
    simulation::World world(object.object(), options.world, kSeed);
    world.reset(draw_start(object.object(), options.start, kSeed), waiting_command());
    Robot robot(world.hand(), world.hand_model(), waiting_command());
    picked = pick(robot, object, options.pick, kSeed);
    log = robot.log();
    model = robot.model();
  }
  localization::ObjectModel object;
  LocateOptions locate_options;
  PickResult picked;
  TouchLog log;
  hand::HandModel model;
};

const PickedBox& scene() {
  static const PickedBox box;
  return box;
}

TEST(Locate, TheLogTellsAllThatTheEstimateDependsOn) {
  ASSERT_TRUE(scene().picked.held);
  const auto again =
      locate(scene().object, scene().model, scene().log, scene().locate_options, PickedBox::kSeed);
  const auto& modes = scene().picked.estimate.posterior.modes;
  ASSERT_EQ(again.posterior.modes.size(), modes.size());
  ASSERT_FALSE(modes.empty());
  EXPECT_EQ(again.posterior.modes[0].T_frame_object.matrix(), modes[0].T_frame_object.matrix());
  EXPECT_FALSE(again.contacts.empty());
}

TEST(Locate, WithoutTheMomentOrATouchThereIsNoPose) {
  ASSERT_TRUE(scene().picked.held);
  TouchLog bare = scene().log;
  bare.moments.clear();
  const auto& s = scene();
  const auto held = locate(s.object, s.model, bare, s.locate_options, 1);
  EXPECT_EQ(held.posterior.status, localization::PoseStatus::no_pose);
  EXPECT_TRUE(held.posterior.modes.empty());
  const auto resting = locate_resting(s.object, s.model, bare, s.locate_options, 1);
  EXPECT_EQ(resting.status, localization::PoseStatus::no_pose);
}

}  // namespace
}  // namespace palpate::pipeline
