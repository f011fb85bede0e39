// SPDX-License-Identifier: Apache-2.0
#include "palpate/estimation/estimate.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "estimation/fallen.hpp"
#include "palpate/evaluation/trial.hpp"
#include "palpate/skills/explore/height_probe_phase.hpp"

namespace palpate::estimation {
namespace {

/// A box that was picked quickly.
struct PickedBox {
  static constexpr std::uint64_t kSeed = 7;
  PickedBox() : object(geometry::load_known_object("box")) {
    evaluation::TrialOptions options;
    options.pick.explore.touches = options.pick.explore.max_touches = 4;
    options.pick.lift.hold = 0.3;
    options.pick.estimation.search.proposals = 20000;
    options.pick.estimation.search.particles = 400;
    options.start.stable_pose = 0;
    locate_options = options.pick.estimation;
    simulation::World world(object.object(), options.world, kSeed);
    world.reset(evaluation::draw_start(object.object(), options.start, kSeed),
                evaluation::waiting_command());
    skills::Executor robot(world.hand(), world.hand_model(), evaluation::waiting_command());
    picked = skills::pick(robot, object, options.pick, kSeed);
    log = robot.log();
    model = robot.model();
  }
  geometry::ObjectModel object;
  EstimationOptions locate_options;
  skills::PickResult picked;
  EventLog log;
  hand::HandModel model;
};

const PickedBox& scene() {
  static const PickedBox box;
  return box;
}

TEST(Locate, MovesAllOfAPosterior) {
  const auto pose = [](double x, double turn) {
    Eigen::Isometry3d T(Eigen::AngleAxisd(turn, Eigen::Vector3d::UnitZ()));
    T.translation().x() = x;
    return T;
  };
  const Eigen::Isometry3d first = pose(0.1, 0.3), second = pose(-0.2, 1.1), by = pose(0.5, -0.8);
  localization::Posterior posterior;
  posterior.modes.push_back({first, 0.5, Matrix6d::Identity(), {}});
  posterior.further = {first, second};
  move(by, posterior);
  EXPECT_TRUE(posterior.modes[0].T_frame_object.isApprox(by * first));
  ASSERT_EQ(posterior.further.size(), 2u);
  EXPECT_TRUE(posterior.further[0].isApprox(by * first));
  EXPECT_TRUE(posterior.further[1].isApprox(by * second));
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
  EventLog bare = scene().log;
  bare.moments.clear();
  const auto& s = scene();
  const auto held = locate(s.object, s.model, bare, s.locate_options, 1);
  EXPECT_EQ(held.posterior.status, localization::PoseStatus::no_pose);
  EXPECT_TRUE(held.posterior.modes.empty());
  const auto resting = estimate_resting_pose(s.object, s.model, bare, s.locate_options, 1);
  EXPECT_EQ(resting.status, localization::PoseStatus::no_pose);
}

TEST(Locate, WhatMayRestTiltedIsKnownLessUpright) {
  const auto& s = scene();
  ASSERT_TRUE(s.picked.held);
  const auto tilt = [&](double sigma) {
    EstimationOptions options = s.locate_options;
    options.resting_tilt_sigma = sigma;
    const auto resting = estimate_resting_pose(s.object, s.model, s.log, options, PickedBox::kSeed);
    return resting.modes.empty() ? 0.0 : resting.modes[0].covariance.topLeftCorner<2, 2>().trace();
  };
  EXPECT_GT(tilt(0.02), 0);
  EXPECT_GT(tilt(0.12), 2 * tilt(0.02));
}

TEST(Locate, WhatMayHaveFallenRestsAsTheLogTells) {
  const auto& s = scene();
  ASSERT_TRUE(s.picked.held);
  EventLog log = s.log;
  const auto felt = std::find_if(log.moments.begin(), log.moments.end(), [](const auto& moment) {
    return moment.mark == TouchEvent::felt;
  });
  ASSERT_NE(felt, log.moments.end());
  const Eigen::Vector2d place = estimation::place_under_hand(log.readings[felt->reading]);
  EXPECT_LT(place.norm(), 0.005);  // the hand came down over the rough place
  log.moments.insert(felt + 1, {TouchEvent::fallen, felt->reading});
  const auto fallen =
      estimate_resting_pose(s.object, s.model, log, s.locate_options, PickedBox::kSeed);
  const auto wider = estimate_resting_pose(s.object, s.model, s.log,
                                           of_fallen(s.locate_options, place), PickedBox::kSeed);
  const auto upright =
      estimate_resting_pose(s.object, s.model, s.log, s.locate_options, PickedBox::kSeed);
  ASSERT_FALSE(fallen.modes.empty());
  EXPECT_EQ(fallen.modes[0].covariance, wider.modes[0].covariance);
  EXPECT_NE(fallen.modes[0].covariance, upright.modes[0].covariance);
}

/// The log of the box, with moments added at its last reading.
EventLog with_moments(std::initializer_list<TouchEvent> marks) {
  EventLog log = scene().log;
  for (const TouchEvent mark : marks) log.moments.push_back({mark, log.readings.size() - 1});
  return log;
}

TEST(Locate, AHandThatHasOpenedKnowsWhatItHeldBefore) {
  const auto& s = scene();
  ASSERT_TRUE(s.picked.held);
  const EventLog put_back = with_moments({TouchEvent::placed});
  const auto before =
      locate(s.object, s.model, put_back, s.locate_options, PickedBox::kSeed, TouchEvent::placed);
  const EventLog opened = with_moments({TouchEvent::placed, TouchEvent::opened});
  const auto resting =
      estimate_resting_pose(s.object, s.model, opened, s.locate_options, PickedBox::kSeed);
  ASSERT_FALSE(resting.modes.empty());
  EXPECT_EQ(resting.modes[0].T_frame_object.matrix(),
            before.posterior.modes[0].T_frame_object.matrix());
  // Closed again on what it has not left, it finds the same pose, by the new touch and that prior.
  const EventLog again = with_moments({TouchEvent::placed, TouchEvent::opened, TouchEvent::closed});
  const auto after =
      locate(s.object, s.model, again, s.locate_options, PickedBox::kSeed, TouchEvent::closed);
  ASSERT_FALSE(after.posterior.modes.empty());
  const auto error = localization::pose_error(after.posterior.modes[0].T_frame_object,
                                              before.posterior.modes[0].T_frame_object,
                                              s.object.object().symmetries);
  EXPECT_LT(error.rotation, 0.05);
  EXPECT_LT(error.translation, 0.003);
}

TEST(Locate, CountsWhatTheFingersTouchedWithTheObjectRolledAside) {
  const auto& s = scene();
  ASSERT_TRUE(s.picked.held);
  const auto once = locate(s.object, s.model, s.log, s.locate_options, PickedBox::kSeed);
  EventLog rolled = s.log;
  rolled.moments.push_back({TouchEvent::rolled, *s.log.at(TouchEvent::held)});
  const auto twice = locate(s.object, s.model, rolled, s.locate_options, PickedBox::kSeed);
  EXPECT_GT(twice.contacts.size(), once.contacts.size());
  rolled.moments.push_back(
      {TouchEvent::opened, *s.log.at(TouchEvent::held)});  // of the grasp before
  rolled.moments.push_back({TouchEvent::held, *s.log.at(TouchEvent::held)});
  const auto anew = locate(s.object, s.model, rolled, s.locate_options, PickedBox::kSeed);
  EXPECT_EQ(anew.contacts.size(), once.contacts.size());
}

TEST(Locate, BalancedForcesChangeTheEstimateALittle) {
  const auto& s = scene();
  ASSERT_TRUE(s.picked.held);
  EstimationOptions options = s.locate_options;
  options.balance = true;
  const auto with = locate(s.object, s.model, s.log, options, PickedBox::kSeed);
  ASSERT_FALSE(with.posterior.modes.empty());
  const auto& mode = s.picked.estimate.posterior.modes[0];
  EXPECT_NE(with.posterior.modes[0].T_frame_object.matrix(), mode.T_frame_object.matrix());
  const auto error = localization::pose_error(with.posterior.modes[0].T_frame_object,
                                              mode.T_frame_object, s.object.object().symmetries);
  EXPECT_LT(error.rotation, 0.05);
  EXPECT_LT(error.translation, 0.003);
  // Before the lift the table bears a part that nobody feels.
  const auto closed = locate(s.object, s.model, s.log, s.locate_options, 1, TouchEvent::closed);
  const auto same = locate(s.object, s.model, s.log, options, 1, TouchEvent::closed);
  EXPECT_EQ(same.posterior.modes[0].T_frame_object.matrix(),
            closed.posterior.modes[0].T_frame_object.matrix());
}

}  // namespace
}  // namespace palpate::estimation
