// SPDX-License-Identifier: Apache-2.0
#include "palpate/evaluation/trial.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <limits>

#include "core/temporary_folder.hpp"
#include "evaluation/quick_options.hpp"
#include "palpate/core/error.hpp"
#include "palpate/core/options.hpp"
#include "palpate/evaluation/evaluation.hpp"
#include "palpate/evaluation/recorder.hpp"
#include "palpate/recording/touch_log.hpp"
#include "palpate/recording/writer.hpp"
#include "palpate/skills/explore/calibrate_phase.hpp"

namespace palpate::evaluation {
namespace {

constexpr std::uint64_t kSeed = 7;

geometry::ObjectModel model(const char* name) {
  return geometry::ObjectModel(geometry::load_known_object(name));
}

void expect_equal(const localization::Mode& a, const localization::Mode& b) {
  EXPECT_EQ(a.T_frame_object.matrix(), b.T_frame_object.matrix());
  EXPECT_EQ(a.weight, b.weight);
  EXPECT_EQ(a.covariance, b.covariance);
  ASSERT_EQ(a.free_axis.has_value(), b.free_axis.has_value());
  if (!a.free_axis) return;
  EXPECT_EQ(a.free_axis->point, b.free_axis->point);
  EXPECT_EQ(a.free_axis->direction, b.free_axis->direction);
  EXPECT_EQ(a.free_axis->extent, b.free_axis->extent);
}

/// Every number of both estimates agrees to the last bit.
void expect_equal(const estimation::HeldPoseEstimate& a, const estimation::HeldPoseEstimate& b) {
  EXPECT_EQ(a.posterior.status, b.posterior.status);
  ASSERT_EQ(a.posterior.modes.size(), b.posterior.modes.size());
  for (std::size_t i = 0; i < a.posterior.modes.size(); ++i) {
    expect_equal(a.posterior.modes[i], b.posterior.modes[i]);
  }
  ASSERT_EQ(a.contacts.size(), b.contacts.size());
  for (std::size_t i = 0; i < a.contacts.size(); ++i) {
    EXPECT_EQ(a.contacts[i].p, b.contacts[i].p);
    EXPECT_EQ(a.contacts[i].n, b.contacts[i].n);
    EXPECT_EQ(a.contacts[i].f, b.contacts[i].f);
  }
}

void expect_equal(const skills::PhaseReport& a, const skills::PhaseReport& b) {
  EXPECT_EQ(a.name, b.name);
  EXPECT_EQ(a.status, b.status);
  EXPECT_EQ(a.outcome, b.outcome);
  EXPECT_EQ(a.robot_seconds, b.robot_seconds);
  EXPECT_EQ(a.contacts, b.contacts);
  EXPECT_EQ(a.peak_force, b.peak_force);
}

/// All but the wall time agrees to the last bit.
void expect_equal(const Trial& a, const Trial& b) {
  EXPECT_EQ(a.start.xy, b.start.xy);
  EXPECT_EQ(a.start.yaw, b.start.yaw);
  EXPECT_EQ(a.start.stable_pose, b.start.stable_pose);
  EXPECT_EQ(a.result.held, b.result.held);
  EXPECT_EQ(a.result.attempts, b.result.attempts);
  EXPECT_EQ(a.result.failed_phase, b.result.failed_phase);
  ASSERT_EQ(a.result.phases.size(), b.result.phases.size());
  for (std::size_t i = 0; i < a.result.phases.size(); ++i) {
    expect_equal(a.result.phases[i], b.result.phases[i]);
  }
  expect_equal(a.result.estimate, b.result.estimate);
  EXPECT_EQ(a.metrics.lifted, b.metrics.lifted);
  EXPECT_EQ(a.metrics.slip, b.metrics.slip);
  EXPECT_EQ(a.metrics.status, b.metrics.status);
  EXPECT_EQ(a.metrics.probability, b.metrics.probability);
  EXPECT_EQ(a.metrics.T_world_object.matrix(), b.metrics.T_world_object.matrix());
}

void expect_equal(const ObjectSummary& a, const ObjectSummary& b) {
  EXPECT_EQ(a.trials, b.trials);
  EXPECT_EQ(a.lifted, b.lifted);
  EXPECT_EQ(a.pose_ok, b.pose_ok);
  EXPECT_EQ(a.covered, b.covered);
  EXPECT_EQ(a.false_hold, b.false_hold);
  EXPECT_EQ(a.modes, b.modes);
  EXPECT_EQ(a.rotation_error_deg, b.rotation_error_deg);
  EXPECT_EQ(a.translation_error_mm, b.translation_error_mm);
  EXPECT_EQ(a.slip_mm, b.slip_mm);
  EXPECT_EQ(a.failures, b.failures);
  EXPECT_EQ(a.symmetry_order, b.symmetry_order);
}

/// A recorded pick of the bunny.
struct RecordedPick {
  explicit RecordedPick(const std::filesystem::path& path) {
    const auto bunny = model("bunny");
    const simulation::World world(bunny.object(), options.world, kSeed);
    recording::Writer writer(path, {"1.2.3", kSeed, bunny.object(), world.hand_model(), ""});
    trial = run_trial(bunny, options, kSeed, &writer);
    writer.finish();
  }
  TrialOptions options = quick_options();
  Trial trial;
};

/// The estimate from what the recording holds and from nothing else.
estimation::HeldPoseEstimate replayed(const recording::Recording& recording,
                                      const estimation::EstimationOptions& options) {
  const geometry::ObjectModel object(recording.header.object);
  auto log = recording::event_log(recording);
  const auto hand = skills::calibrated_hand(recording.header.hand, log, {});
  return estimation::PoseEstimator(object, options, recording.header.seed)
      .held(hand, log, log.at(estimation::TouchEvent::held));
}

void forget_truth(recording::Recording& recording) {
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  for (auto& frame : recording.frames) {
    ASSERT_TRUE(frame.truth);
    frame.truth->T_world_object.matrix().setConstant(kNan);
    frame.truth->joints.setConstant(kNan);
  }
}

TEST(Trial, RecordingAloneGivesThePicksPoseToTheLastBit) {
  const TemporaryFolder folder;
  const RecordedPick pick(folder.path() / "pick.h5");
  ASSERT_TRUE(pick.trial.result.held);
  ASSERT_FALSE(pick.trial.result.estimate.posterior.modes.empty());
  ASSERT_FALSE(pick.trial.result.estimate.contacts.empty());
  EXPECT_TRUE(pick.trial.metrics.lifted);
  ASSERT_GT(pick.trial.metrics.probes, 0);

  auto recording = recording::read_recording(folder.path() / "pick.h5");
  expect_equal(pick.trial.result.estimate, replayed(recording, pick.options.pick.estimation));

  forget_truth(recording);
  expect_equal(pick.trial.result.estimate, replayed(recording, pick.options.pick.estimation));

  recording::write_recording(folder.path() / "blind.h5", recording);
  const auto blind = recording::read_recording(folder.path() / "blind.h5");
  ASSERT_FALSE(blind.frames.empty());
  EXPECT_EQ(blind.frames.size(), recording.frames.size());
  expect_equal(pick.trial.result.estimate, replayed(blind, pick.options.pick.estimation));
}

TEST(Trial, GraspsAnewFromAnotherSideAndKeepsWhatItKnew) {
  const TemporaryFolder folder;
  const auto path = folder.path() / "pick.h5";
  TrialOptions options = quick_options();
  options.pick.palpation.max = 0;
  options.pick.palpation.regrasps = 1;
  const auto box = model("box");
  const simulation::World world(box.object(), options.world, kSeed);
  recording::Writer writer(path, {"1.2.3", kSeed, box.object(), world.hand_model(), ""});
  const Trial trial = run_trial(box, options, kSeed, &writer);
  writer.finish();
  EXPECT_GE(trial.result.regrasps, 1);
  EXPECT_TRUE(trial.metrics.lifted);
  EXPECT_TRUE(trial.metrics.pose_ok);
  const auto recording = recording::read_recording(path);
  const auto log = recording::event_log(recording);
  EXPECT_TRUE(log.before_opening());
  expect_equal(trial.result.estimate, replayed(recording, options.pick.estimation));
}

TEST(Trial, WhatHasSlippedIsPressedHarder) {
  TrialOptions options = quick_options();
  options.world.hand_friction = 0.25;  // 0.5 is believed
  options.pick.palpation.max = 0;      // no finger lets go of it to probe
  const Trial trial = run_trial(model("box"), options, kSeed);
  EXPECT_TRUE(trial.metrics.lifted);
  EXPECT_GT(trial.result.attempts, 1) << "the first grasp was to slip";
  EXPECT_TRUE(trial.result.held);
}

/// Of a mug that is touched by closing the hand alone, so that its pose stays unknown, in a scene
/// in which that holds it.
Trial run_blind_trial(int attempts) {
  TrialOptions options = quick_options();
  options.pick.explore.touches = 0;
  options.pick.palpation.max = 0;
  options.pick.attempts = attempts;
  return run_trial(model("mug"), options, kSeed + 2);
}

TEST(Trial, WhatIsHeldInAnUnknownPoseIsPutDownAndTouchedAgain) {
  const Trial trial = run_blind_trial(2);
  EXPECT_GE(trial.result.attempts, 2);  // those in which the grip gives way do not count
  std::vector<std::string> names;
  for (const auto& phase : trial.result.phases) names.push_back(phase.name);
  auto next = names.begin();
  for (const char* name : {"lift", "pose", "put-down", "height_probe", "grasp"}) {
    next = std::find(next, names.end(), name);
    EXPECT_NE(next, names.end()) << name;
  }
}

TEST(Trial, WhatStaysInAnUnknownPoseIsPutDownOnce) {
  const Trial trial = run_blind_trial(4);
  const auto downs = std::count_if(trial.result.phases.begin(), trial.result.phases.end(),
                                   [](const auto& phase) { return phase.name == "put-down"; });
  EXPECT_EQ(downs, 1);
  EXPECT_TRUE(trial.result.held);
}

TEST(Trial, PutsDownWhatHangsToGraspItAnew) {
  TrialOptions options = quick_options();
  options.pick.estimate_before_lift = false;
  options.pick.palpation.max = 0;
  options.pick.palpation.regrasps = 1;
  const Trial trial = run_trial(model("box"), options, kSeed);
  EXPECT_GE(trial.result.regrasps, 1);
  EXPECT_TRUE(trial.metrics.lifted);
  EXPECT_TRUE(trial.metrics.pose_ok);
  std::vector<std::string> names;
  for (const auto& phase : trial.result.phases) names.push_back(phase.name);
  const auto lift = std::find(names.begin(), names.end(), "lift");
  const auto down = std::find(lift, names.end(), "put-down");
  EXPECT_NE(std::find(down, names.end(), "lift"), names.end());
}

TEST(Trial, TouchesTheTableWithWhatItHolds) {
  const TemporaryFolder folder;
  const auto path = folder.path() / "pick.h5";
  TrialOptions options = quick_options();
  options.pick.palpation.max = 0;
  options.pick.palpation.table_touches = 3;
  options.pick.palpation.tight = 1;  // however well its pose is known
  const auto box = model("box");
  const simulation::World world(box.object(), options.world, kSeed);
  recording::Writer writer(path, {"1.2.3", kSeed, box.object(), world.hand_model(), ""});
  const Trial trial = run_trial(box, options, kSeed, &writer);
  writer.finish();
  EXPECT_TRUE(trial.metrics.lifted);
  EXPECT_TRUE(trial.metrics.pose_tight);
  const auto recording = recording::read_recording(path);
  auto log = recording::event_log(recording);
  EXPECT_EQ(log.all(estimation::TouchEvent::table_touched).size(), 3u);
  expect_equal(trial.result.estimate, replayed(recording, options.pick.estimation));
}

TEST(Trial, SameSeedGivesTheSameTrialRecordedOrNot) {
  const TemporaryFolder folder;
  const RecordedPick pick(folder.path() / "pick.h5");
  expect_equal(pick.trial, run_trial(model("bunny"), pick.options, kSeed));
}

TEST(EventLog, HoldsTheMomentsSinceTheRelease) {
  estimation::EventLog log;
  log.readings.resize(6);
  log.moments = {{estimation::TouchEvent::closed, 0},
                 {estimation::TouchEvent::released, 1},
                 {estimation::TouchEvent::closed, 2},
                 {estimation::TouchEvent::probed, 3},
                 {estimation::TouchEvent::closed, 4}};
  EXPECT_EQ(log.all(estimation::TouchEvent::closed), (std::vector<std::size_t>{2, 4}));
  EXPECT_EQ(log.at(estimation::TouchEvent::closed), 4U);
  EXPECT_EQ(log.all(estimation::TouchEvent::probed), (std::vector<std::size_t>{3}));
  EXPECT_TRUE(log.all(estimation::TouchEvent::held).empty());
}

TEST(Trial, NoProbesWhereTheyAreSwitchedOff) {
  TrialOptions options = quick_options();
  options.pick.palpation.max = 0;
  const Trial trial = run_trial(model("box"), options, kSeed);
  EXPECT_EQ(trial.metrics.probes, 0);
  for (const auto& phase : trial.result.phases) EXPECT_NE(phase.name, "probe");
}

TEST(Evaluation, NumberOfThreadsDoesNotChangeTheSummaries) {
  const auto box = model("box");
  const geometry::KnownObject bracket = geometry::load_known_object("bracket");
  const std::vector<EvaluatedObject> objects = {
      {&box.object(), {0, 2}, &box}, {&bracket, {}}, {&bracket, {1}}};
  TrialOptions options = quick_options();
  options.pick.attempts = 1;
  options.pick.lift.hold = 0.2;
  std::vector<ObjectSummary> one, two;
  std::vector<std::string> order;
  evaluate(objects, options, 20, 1,
           {.object = [&](std::size_t, const auto& summary) { one.push_back(summary); }});
  evaluate(
      objects, options, 20, 2,
      {.trial = [&](TrialId id,
                    const Trial&) { order.push_back(fmt::format("{}.{}", id.object, id.number)); },
       .object =
           [&](std::size_t object, const auto& summary) {
             order.push_back(fmt::format("{} ends", object));
             two.push_back(summary);
           }});
  const std::vector<std::string> expected = {"0.0", "0.2", "0 ends", "1 ends", "2.1", "2 ends"};
  EXPECT_EQ(order, expected);
  ASSERT_EQ(one.size(), 3u);
  ASSERT_EQ(two.size(), 3u);
  EXPECT_EQ(one[0].trials, 2u);
  EXPECT_EQ(one[1].trials, 0u);
  for (std::size_t i = 0; i < 3; ++i) expect_equal(one[i], two[i]);
}

TEST(Evaluation, OfFinishedTrialsPreparesNothing) {
  const geometry::KnownObject box = geometry::load_known_object("box");
  std::size_t trials = 0;
  evaluate({{&box, {0, 1}}}, quick_options(), 20, 1,
           {.finished = [](TrialId) { return std::make_optional<Trial>(); },
            .sink = [](TrialId) -> std::shared_ptr<recording::Sink> {
              throw std::logic_error("a finished trial is run");
            },
            .object = [&](std::size_t, const auto& summary) { trials = summary.trials; }});
  EXPECT_EQ(trials, 2u);
}

TEST(CheckTrial, RefusesWhatNoTrialCanBeOf) {
  const geometry::KnownObject box = geometry::load_known_object("box");
  EXPECT_NO_THROW(check_trial(box, {}, kSeed));
  const auto refused = [&](const auto& change) {
    TrialOptions options;
    change(options);
    EXPECT_THROW(check_trial(box, options, kSeed), BadInput);
  };
  refused([](TrialOptions& o) { o.touch.source = "skin"; });
  refused([](TrialOptions& o) { o.fault.kind = "nonsense"; });
  refused([](TrialOptions& o) { o.start.stable_pose = 99; });
  refused([](TrialOptions& o) { o.place.target = "shelf"; });
  refused([](TrialOptions& o) {  // where the fixture stands
    o.place.target = "fixture";
    o.start.x = 0.25;
    o.start.y = 0.15;
  });
}

TEST(TrialOptions, TheExampleOfAConfigurationNamesTheDefaults) {
  TrialOptions options;
  load_toml(PALPATE_CONFIGS "/pick.toml", options);
  EXPECT_EQ(to_toml(options), to_toml(TrialOptions()));
}

TEST(TrialOptions, DifferFromWhatTheRobotBelievesUnlessTheyAreIdeal) {
  TrialOptions options;
  EXPECT_GT(options.world.error.table_height, 0);
  EXPECT_GT(options.world.noise.mount_delay, 0);
  load_toml(PALPATE_CONFIGS "/ideal.toml", options);
  EXPECT_EQ(to_toml(options), to_toml(TrialOptions::ideal()));
}

TEST(TrialOptions, BelieveOneFriction) {
  TrialOptions options;
  options.friction = 0.3;
  const skills::PickOptions pick = options.pick_options();
  EXPECT_EQ(pick.grasp.friction, 0.3);
  EXPECT_EQ(pick.palpation.friction, 0.3);
  EXPECT_EQ(options.place_options().fingers.reorient.friction, 0.3);
  EXPECT_EQ(options.forward_model_options().hand_friction, 0.3);
  // Where the object may still move in the hand, forces count on less.
  EXPECT_EQ(pick.grasp.plan.friction, options.place_options().transport.friction);
  EXPECT_LT(pick.grasp.plan.friction, 0.3);
}

TEST(TouchOptions, SayHowFarInferredContactsMayBeOff) {
  TrialOptions options = TrialOptions::ideal();
  EXPECT_EQ(options.pick_options().estimation.errors.point_floor,
            estimation::EstimationOptions().errors.point_floor);
  options.touch = {
      .source = "biotac", .biotac_point = 0.003, .biotac_normal = 0.4, .biotac_false = 0.07};
  const estimation::EstimationOptions locate = options.pick_options().estimation;
  EXPECT_EQ(locate.errors.point_floor, 0.003);
  EXPECT_EQ(locate.errors.normal_floor, 0.4);
  EXPECT_EQ(locate.false_contacts, 0.07);
  options.touch.source = "nose";
  EXPECT_THROW((void)options.pick_options(), BadInput);
}

}  // namespace
}  // namespace palpate::evaluation
