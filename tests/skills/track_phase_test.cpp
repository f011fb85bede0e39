// SPDX-License-Identifier: Apache-2.0
#include "palpate/skills/grasp/track_phase.hpp"

#include <gtest/gtest.h>

#include "hand/descriptions.hpp"
#include "palpate/core/assets.hpp"
#include "palpate/core/error.hpp"
#include "palpate/evaluation/trial.hpp"
#include "palpate/simulation/hand/load_hand.hpp"

namespace palpate::skills {
namespace {

constexpr std::uint64_t kSeed = 3;

const geometry::ObjectModel& box() {
  static const geometry::ObjectModel model(geometry::load_known_object("box"));
  return model;
}

evaluation::TrialOptions quick_options() {
  evaluation::TrialOptions options = evaluation::TrialOptions::ideal();
  options.pick.explore.touches = options.pick.explore.max_touches = 6;
  options.pick.palpation.max = options.pick.palpation.regrasps = 0;
  options.pick.palpation.table_touches = 0;
  options.pick.lift.hold = 0.5;
  options.pick.estimation.search.proposals = 20000;
  options.pick.estimation.search.particles = 400;
  return options;
}

TEST(TrackPhase, FollowsTheObjectThroughTheLift) {
  const auto trial = evaluation::run_trial(box(), quick_options(), kSeed);
  ASSERT_TRUE(trial.metrics.lifted);
  ASSERT_TRUE(trial.metrics.pose_ok_before_lift);
  ASSERT_TRUE(trial.result.tracked);
  EXPECT_GT(trial.result.tracked->looks.size(), 10u);
  EXPECT_TRUE(trial.metrics.pose_ok_tracked);
  EXPECT_GE(trial.metrics.tracked_share, 0.95);
  const auto& phases = trial.result.phases;
  ASSERT_GE(phases.size(), 2u);
  EXPECT_EQ(phases[phases.size() - 2].name, "track");
}

TEST(TrackPhase, HasNothingToFollowWithoutAnEstimateBefore) {
  evaluation::TrialOptions options = quick_options();
  options.pick.estimate_before_lift = false;
  const auto trial = evaluation::run_trial(box(), options, kSeed);
  EXPECT_FALSE(trial.result.tracked);
  EXPECT_FALSE(trial.metrics.pose_ok_tracked);
}

/// A log of a hand that rises with what it holds, and senses nothing.
struct Standing {
  explicit Standing(std::size_t readings)
      : hand(simulation::load_shadow_hand(asset("shadow_hand/right_hand.xml"))) {
    hand::HandReading reading = hand::resting_reading();
    for (std::size_t i = 0; i < readings; ++i) {
      reading.time = static_cast<double>(i) * hand::kTick;
      reading.mount.xyz.z() += 0.001;
      log.readings.push_back(reading);
    }
    localization::Mode mode;
    mode.T_frame_object = log.readings[0].mount.pose();
    mode.weight = 1;
    mode.covariance = 1e-6 * Matrix6d::Identity();
    start.modes = {mode};
  }
  estimation::Tracked track(std::size_t first, std::size_t last) const {
    return estimation::track({box(), hand, log, start, first, last}, {}, kSeed);
  }

  hand::Description hand;
  estimation::EventLog log;
  localization::Posterior start;
};

TEST(Track, StaysInTheHandThatRises) {
  const Standing scene(60);
  const auto tracked = scene.track(0, 59);
  ASSERT_EQ(tracked.looks.size(), 4u);  // the first needs readings before it
  for (const auto& look : tracked.looks) {
    EXPECT_LT(look.T_mount_object.translation().norm(), 1e-6);
  }
  EXPECT_EQ(tracked.slips, 0);
}

TEST(Track, DoesNotLookWhereThereIsNoTime) {
  const Standing scene(60);
  EXPECT_TRUE(scene.track(50, 55).looks.empty());
}

TEST(Track, RefusesReadingsThatAreNotThere) {
  const Standing scene(60);
  EXPECT_THROW(scene.track(10, 60), BadInput);
  EXPECT_THROW(scene.track(20, 10), BadInput);
}

}  // namespace
}  // namespace palpate::skills
