// SPDX-License-Identifier: Apache-2.0
// Nothing that the hand is commanded depends on the simulator's truth: with a false one it is given
// the same, to the last bit.
#include <gtest/gtest.h>

#include <vector>

#include "core/temporary_folder.hpp"
#include "evaluation/quick_options.hpp"
#include "palpate/recording/recording.hpp"
#include "palpate/recording/writer.hpp"

namespace palpate::evaluation {
namespace {

constexpr std::uint64_t kSeed = 7;

struct PhaseSequence {
  Trial trial;
  std::vector<recording::Frame> frames;
};

PhaseSequence course_of(const char* name, TrialOptions options, bool corrupted_truth,
                        std::uint64_t seed) {
  options.world.corrupted_truth = corrupted_truth;
  const geometry::ObjectModel object(geometry::load_known_object(name));
  const simulation::World world(object.object(), options.world, seed);
  const TemporaryFolder folder;
  const auto path = folder.path() / "recording.h5";
  recording::Writer writer(path, {"1.2.3", seed, object.object(), world.hand_model(), ""});
  PhaseSequence course;
  course.trial = run_trial(object, options, seed, &writer);
  writer.finish();
  course.frames = recording::read_recording(path).frames;
  return course;
}

/// @return the course with the right truth
PhaseSequence expect_blind(const char* name, const TrialOptions& options,
                           std::uint64_t seed = kSeed) {
  PhaseSequence right = course_of(name, options, false, seed);
  const PhaseSequence wrong = course_of(name, options, true, seed);
  EXPECT_GT(right.frames.size(), 1000u);
  EXPECT_EQ(right.frames.size(), wrong.frames.size());
  for (std::size_t i = 0; i < std::min(right.frames.size(), wrong.frames.size()); ++i) {
    const auto &a = right.frames[i], &b = wrong.frames[i];
    EXPECT_NE(a.truth->T_world_object.matrix(), b.truth->T_world_object.matrix());
    const bool same = a.command.positions == b.command.positions &&
                      a.command.mount.xyz == b.command.mount.xyz &&
                      a.command.mount.ypr == b.command.mount.ypr;
    EXPECT_TRUE(same) << "in frame " << i;
    if (!same) break;
  }
  EXPECT_FALSE(wrong.trial.metrics.pose_ok);  // who judges by the truth is misled
  return right;
}

TEST(Blind, PlacingOnASpotDoesNotSeeTheTruth) {
  const auto course = expect_blind("box", quick_place_options());
  EXPECT_EQ(course.trial.strategy.strategy, skills::PlaceStrategy::wrist);
  EXPECT_TRUE(course.trial.place_metrics.placed);
}

TEST(Blind, TurningByTheFingersDoesNotSeeTheTruth) {
  TrialOptions options = quick_place_options();
  options.place.strategy = "fingers";
  options.place.fingers.reorient.sampling.samples = 8;
  const auto course = expect_blind("box", options, 3);  // of which the pose is certain enough
  EXPECT_EQ(course.trial.strategy.strategy, skills::PlaceStrategy::fingers);
}

TEST(Blind, RegraspingDoesNotSeeTheTruth) {
  TrialOptions options = quick_place_options();
  options.start.stable_pose = 1;
  options.place.target = "stable_pose";
  options.place.stable_pose = 4;
  options.place.strategy = "regrasp";
  const auto course = expect_blind("box", options);
  EXPECT_EQ(course.trial.strategy.strategy, skills::PlaceStrategy::regrasp);
}

}  // namespace
}  // namespace palpate::evaluation
