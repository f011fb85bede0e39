// SPDX-License-Identifier: Apache-2.0
#include "palpate/estimation/estimate.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "estimation/fallen.hpp"
#include "palpate/core/error.hpp"
#include "palpate/evaluation/trial.hpp"
#include "palpate/skills/explore/height_probe_phase.hpp"

namespace palpate::estimation {
namespace {

/// A box that was picked quickly.
struct PickedBox {
  static constexpr std::uint64_t kSeed = 7;
  PickedBox() : object(geometry::load_known_object("box")) {
    evaluation::TrialOptions options = evaluation::TrialOptions::ideal();
    options.pick.explore.touches = options.pick.explore.max_touches = 4;
    options.pick.lift.hold = 0.3;
    options.pick.palpation.table_touches = 0;
    options.pick.estimation.search.proposals = 20000;
    options.pick.estimation.search.particles = 400;
    options.start.stable_pose = 0;
    locate_options = options.pick.estimation;
    simulation::World world(object.object(), options.world, kSeed);
    world.reset(evaluation::draw_start(object.object(), options.start, kSeed),
                evaluation::waiting_command(world.hand_model()));
    skills::Executor robot(world.hand(), world.hand_model(),
                           evaluation::waiting_command(world.hand_model()));
    picked = skills::pick(robot, object, options.pick, kSeed);
    log = robot.log();
    model = robot.model();
  }
  geometry::ObjectModel object;
  EstimationOptions locate_options;
  skills::PickResult picked;
  EventLog log;
  hand::Description model;
};

const PickedBox& scene() {
  static const PickedBox box;
  return box;
}

TEST(EstimateHeldPose, MovesAllOfAPosterior) {
  const auto pose = [](double x, double turn) {
    Eigen::Isometry3d T(Eigen::AngleAxisd(turn, Eigen::Vector3d::UnitZ()));
    T.translation().x() = x;
    return T;
  };
  const Eigen::Isometry3d first = pose(0.1, 0.3), second = pose(-0.2, 1.1), by = pose(0.5, -0.8);
  localization::Posterior posterior;
  posterior.modes.push_back({first, 0.5, Matrix6d::Identity(), {}});
  posterior.residual_set = {first, second};
  transform(by, posterior);
  EXPECT_TRUE(posterior.modes[0].T_frame_object.isApprox(by * first));
  ASSERT_EQ(posterior.residual_set.size(), 2u);
  EXPECT_TRUE(posterior.residual_set[0].isApprox(by * first));
  EXPECT_TRUE(posterior.residual_set[1].isApprox(by * second));
}

HeldPoseEstimate held_pose(const EventLog& log, const EstimationOptions& options,
                           std::uint64_t seed, TouchEvent instant = TouchEvent::held) {
  return PoseEstimator(scene().object, options, seed).held(scene().model, log, log.at(instant));
}

TEST(EstimateHeldPose, TheLogHoldsAllThatTheEstimateDependsOn) {
  ASSERT_TRUE(scene().picked.held);
  const auto again = held_pose(scene().log, scene().locate_options, PickedBox::kSeed);
  const auto& modes = scene().picked.estimate.posterior.modes;
  ASSERT_EQ(again.posterior.modes.size(), modes.size());
  ASSERT_FALSE(modes.empty());
  EXPECT_EQ(again.posterior.modes[0].T_frame_object.matrix(), modes[0].T_frame_object.matrix());
  EXPECT_FALSE(again.contacts.empty());
}

TEST(EstimateHeldPose, WithoutTheMomentOrATouchThereIsNoPose) {
  ASSERT_TRUE(scene().picked.held);
  EventLog bare = scene().log;
  bare.moments.clear();
  const auto& s = scene();
  const auto held = held_pose(bare, s.locate_options, 1);
  EXPECT_EQ(held.posterior.status, localization::PoseStatus::no_pose);
  EXPECT_TRUE(held.posterior.modes.empty());
  const auto resting = PoseEstimator(s.object, s.locate_options, 1).resting(s.model, bare);
  EXPECT_EQ(resting.status, localization::PoseStatus::no_pose);
}

TEST(EstimateHeldPose, WhatMayRestTiltedIsKnownLessUpright) {
  const auto& s = scene();
  ASSERT_TRUE(s.picked.held);
  const auto tilt = [&](double sigma) {
    EstimationOptions options = s.locate_options;
    options.resting_tilt_sigma = sigma;
    const auto resting = PoseEstimator(s.object, options, PickedBox::kSeed).resting(s.model, s.log);
    return resting.modes.empty() ? 0.0 : resting.modes[0].covariance.topLeftCorner<2, 2>().trace();
  };
  EXPECT_GT(tilt(0.02), 0);
  EXPECT_GT(tilt(0.12), 2 * tilt(0.02));
}

TEST(EstimateHeldPose, WhatMayHaveFallenRestsAsTheLogStates) {
  const auto& s = scene();
  ASSERT_TRUE(s.picked.held);
  EventLog log = s.log;
  const auto probed = std::find_if(log.moments.begin(), log.moments.end(), [](const auto& moment) {
    return moment.event == TouchEvent::height_probed;
  });
  ASSERT_NE(probed, log.moments.end());
  const Eigen::Vector2d place =
      estimation::place_under_hand(s.model, log.readings[probed->reading]);
  EXPECT_LT(place.norm(), 0.005);  // the hand came down over the rough place
  log.moments.insert(probed + 1, {TouchEvent::fallen, probed->reading});
  const auto fallen =
      PoseEstimator(s.object, s.locate_options, PickedBox::kSeed).resting(s.model, log);
  const auto wider = PoseEstimator(s.object, of_fallen(s.locate_options, place), PickedBox::kSeed)
                         .resting(s.model, s.log);
  const auto upright =
      PoseEstimator(s.object, s.locate_options, PickedBox::kSeed).resting(s.model, s.log);
  ASSERT_FALSE(fallen.modes.empty());
  EXPECT_EQ(fallen.modes[0].covariance, wider.modes[0].covariance);
  EXPECT_NE(fallen.modes[0].covariance, upright.modes[0].covariance);
}

/// The log of the box, with moments added at its last reading.
EventLog with_moments(std::initializer_list<TouchEvent> events) {
  EventLog log = scene().log;
  for (const TouchEvent event : events) log.moments.push_back({event, log.readings.size() - 1});
  return log;
}

TEST(EstimateHeldPose, AHandThatHasOpenedKnowsWhatItHeldBefore) {
  const auto& s = scene();
  ASSERT_TRUE(s.picked.held);
  const EventLog put_back = with_moments({TouchEvent::placed});
  const auto before = held_pose(put_back, s.locate_options, PickedBox::kSeed, TouchEvent::placed);
  const EventLog opened = with_moments({TouchEvent::placed, TouchEvent::opened});
  const auto resting =
      PoseEstimator(s.object, s.locate_options, PickedBox::kSeed).resting(s.model, opened);
  ASSERT_FALSE(resting.modes.empty());
  EXPECT_EQ(resting.modes[0].T_frame_object.matrix(),
            before.posterior.modes[0].T_frame_object.matrix());
  // Closed again on what it has not left, it finds the same pose, by the new touch and that prior.
  const EventLog again = with_moments({TouchEvent::placed, TouchEvent::opened, TouchEvent::closed});
  const auto after = held_pose(again, s.locate_options, PickedBox::kSeed, TouchEvent::closed);
  ASSERT_FALSE(after.posterior.modes.empty());
  const auto error = localization::pose_error(after.posterior.modes[0].T_frame_object,
                                              before.posterior.modes[0].T_frame_object,
                                              s.object.object().symmetries);
  EXPECT_LT(error.rotation, 0.05);
  EXPECT_LT(error.translation, 0.003);
}

TEST(EstimateHeldPose, HasAPoseAtAnyInstant) {
  const auto& s = scene();
  ASSERT_TRUE(s.picked.held);
  // Between closing and hanging the hand lifts; the pose rises with it.
  const std::size_t closed = *s.log.at(TouchEvent::closed), held = *s.log.at(TouchEvent::held);
  const std::size_t between = (closed + held) / 2;
  const auto height = [&](std::size_t at) {
    const auto estimate =
        PoseEstimator(s.object, s.locate_options, PickedBox::kSeed).held(s.model, s.log, at);
    return estimate.posterior.modes.at(0).T_frame_object.translation().z() -
           s.log.readings[at].mount.xyz.z();
  };
  EXPECT_GT(s.log.readings[between].mount.xyz.z(), s.log.readings[closed].mount.xyz.z());
  EXPECT_NEAR(height(between), height(held), 0.004);
}

TEST(PoseEstimator, SearchesForTheRestingPoseAgainOnlyWhereTheLogHoldsMoreOfIt) {
  const auto& s = scene();
  ASSERT_TRUE(s.picked.held);
  PoseEstimator estimator(s.object, s.locate_options, PickedBox::kSeed);
  const auto first = estimator.resting(s.model, s.log);
  const auto same = estimator.resting(s.model, with_moments({TouchEvent::probed}));
  EXPECT_EQ(same.seconds, first.seconds);  // to the last bit: of one and the same search
  EventLog fewer = s.log;
  std::erase_if(fewer.moments, [](const auto& m) { return m.event == TouchEvent::missed; });
  const auto last = std::find_if(fewer.moments.rbegin(), fewer.moments.rend(),
                                 [](const auto& m) { return m.event == TouchEvent::touched; });
  ASSERT_NE(last, fewer.moments.rend());
  fewer.moments.erase(std::next(last).base());
  const auto without = estimator.resting(s.model, fewer);
  const auto alone = PoseEstimator(s.object, s.locate_options, PickedBox::kSeed);
  EXPECT_NE(without.modes[0].T_frame_object.matrix(), first.modes[0].T_frame_object.matrix());
  EXPECT_EQ(without.modes[0].T_frame_object.matrix(),
            PoseEstimator(alone).resting(s.model, fewer).modes[0].T_frame_object.matrix());
}

TEST(EstimateHeldPose, BalancedForcesChangeTheEstimateALittle) {
  const auto& s = scene();
  ASSERT_TRUE(s.picked.held);
  EstimationOptions options = s.locate_options;
  options.balance = true;
  const auto with = held_pose(s.log, options, PickedBox::kSeed);
  ASSERT_FALSE(with.posterior.modes.empty());
  const auto& mode = s.picked.estimate.posterior.modes[0];
  EXPECT_NE(with.posterior.modes[0].T_frame_object.matrix(), mode.T_frame_object.matrix());
  const auto error = localization::pose_error(with.posterior.modes[0].T_frame_object,
                                              mode.T_frame_object, s.object.object().symmetries);
  EXPECT_LT(error.rotation, 0.05);
  EXPECT_LT(error.translation, 0.003);
  // Before the lift the table bears a part that no fingertip senses.
  const auto closed = held_pose(s.log, s.locate_options, 1, TouchEvent::closed);
  const auto same = held_pose(s.log, options, 1, TouchEvent::closed);
  EXPECT_EQ(same.posterior.modes[0].T_frame_object.matrix(),
            closed.posterior.modes[0].T_frame_object.matrix());
}

TEST(Candidates, AreDistinguishedByTheTouchesAndInTheHand) {
  ASSERT_TRUE(scene().picked.held);
  const geometry::ObjectModel mug(geometry::load_known_object("mug"));
  const PickedBox& s = scene();
  PoseEstimator alone(s.object, s.locate_options, PickedBox::kSeed);
  PoseEstimator estimator(Candidates{&mug, &s.object}, s.locate_options, PickedBox::kSeed);
  EXPECT_EQ(&estimator.object(), &mug);  // the first, before anything is known
  const auto resting = estimator.resting(s.model, s.log);
  ASSERT_EQ(&estimator.object(), &s.object);
  ASSERT_EQ(estimator.posteriors().size(), 2u);
  EXPECT_NEAR(resting.modes[0].weight / alone.resting(s.model, s.log).modes[0].weight,
              estimator.probabilities().candidates[1], 0.05);
  const auto held = estimator.held(s.model, s.log, s.log.at(TouchEvent::held));
  const auto truth = alone.held(s.model, s.log, s.log.at(TouchEvent::held));
  EXPECT_GT(estimator.probabilities().candidates[1], 0.95);
  EXPECT_EQ(estimator.probabilities().best, 1u);
  const auto error = localization::pose_error(held.posterior.modes[0].T_frame_object,
                                              truth.posterior.modes[0].T_frame_object,
                                              s.object.object().symmetries);
  EXPECT_LT(error.rotation, 0.05);
  EXPECT_LT(error.translation, 0.003);
}

TEST(Candidates, OfWhichTheObjectIsNoneAreNotCertain) {
  const geometry::ObjectModel mug(geometry::load_known_object("mug"));
  const geometry::ObjectModel bracket(geometry::load_known_object("bracket"));
  const PickedBox& s = scene();
  PoseEstimator estimator(Candidates{&mug, &bracket}, s.locate_options, PickedBox::kSeed);
  const auto held = estimator.held(s.model, s.log, s.log.at(TouchEvent::held));
  EXPECT_LT(localization::best_probability(held.posterior), 0.5);
}

/// The log of the box, its touches so far apart that no pose of anything explains them.
EventLog with_touches_apart() {
  constexpr std::size_t kReadings = 300;  // before a touch
  EventLog log = scene().log;
  double apart = 0;
  for (const std::size_t touched : log.all(TouchEvent::touched)) {
    apart += 0.15;
    for (std::size_t i = touched - std::min(touched, kReadings); i <= touched; ++i) {
      log.readings[i].mount.xyz.x() = scene().log.readings[i].mount.xyz.x() + apart;
    }
  }
  return log;
}

TEST(Candidates, AreDistinguishedInTheHandWhereNoneExplainsTheTouchesBefore) {
  ASSERT_TRUE(scene().picked.held);
  const geometry::ObjectModel mug(geometry::load_known_object("mug"));
  const PickedBox& s = scene();
  const EventLog log = with_touches_apart();
  PoseEstimator estimator(Candidates{&mug, &s.object}, s.locate_options, PickedBox::kSeed);
  ASSERT_EQ(estimator.resting(s.model, log).status, localization::PoseStatus::no_pose);
  EXPECT_EQ(estimator.probabilities().candidates, std::vector<double>(2, 0.5));
  for (const TouchEvent instant : {TouchEvent::closed, TouchEvent::held}) {
    const auto held = estimator.held(s.model, log, log.at(instant));
    const auto& found = estimator.probabilities();
    EXPECT_NEAR(found.candidates[0] + found.candidates[1] + found.other, 1, 1e-9);
    EXPECT_GT(found.candidates[1], found.candidates[0]);
    EXPECT_FALSE(held.posterior.modes.empty());
  }
}

TEST(Candidates, ThatAreNoneAreRefused) {
  EXPECT_THROW(PoseEstimator(Candidates{}, {}, 1), BadInput);
}

}  // namespace
}  // namespace palpate::estimation
