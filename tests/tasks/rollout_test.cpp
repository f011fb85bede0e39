// SPDX-License-Identifier: Apache-2.0
#include "palpate/tasks/relocate/rollout.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <string>

#include "core/temporary_folder.hpp"
#include "data.hpp"
#include "palpate/core/assets.hpp"
#include "palpate/core/error.hpp"
#include "palpate/geometry/io/mesh_io.hpp"
#include "palpate/geometry/objects/shapes.hpp"
#include "palpate/tasks/relocate/policies/policy_io.hpp"
#include "tasks/policies.hpp"

namespace palpate::relocate {
namespace {

TaskOptions fast_task() {
  TaskOptions options;
  options.solver = "fast";
  return options;
}

/// Returns not-a-number from a step on.
class BreakingPolicy : public Policy {
 public:
  RelocateAction act(const PolicyInput& input) const override {
    const bool broken = input.observation.head<3>().norm() > 0.01;
    return RelocateAction::Constant(broken ? std::numeric_limits<double>::quiet_NaN() : 1);
  }
  PolicyRecord record() const override { return {}; }
};

TEST(Rollout, IsTheSameForAnyNumberOfThreads) {
  const auto model = make_model(fast_task());
  const auto policy = small_network(2);
  EpisodeOptions options;
  options.horizon = 12;
  const auto one = returns(rollout(model, policy, options, 7, 6, 1));
  EXPECT_EQ(returns(rollout(model, policy, options, 7, 6, 3)), one);
  EXPECT_NE(returns(rollout(model, policy, options, 8, 6, 1)), one);
}

TEST(Rollout, OneSeedStandsForAnEpisodeOfASeed) {
  EpisodeOptions options;
  options.scale_high = 1;
  const std::uint64_t seed = episode_seed(9, 4);
  EXPECT_EQ(seed, 9 * 1048576U + 4);
  const auto start = episode_start(options, 9, 4), again = episode_start(options, seed);
  EXPECT_EQ(again.object, start.object);
  EXPECT_EQ(again.target, start.target);
  EXPECT_NE(episode_start(options, seed + 1).target, start.target);
  EXPECT_THROW(episode_seed(9, std::size_t{1} << 20), BadInput);
  EXPECT_THROW(episode_seed(std::uint64_t{1} << 43, 0), BadInput);
}

TEST(Rollout, APathHoldsTheTruthFromTheStartOn) {
  const auto model = make_model(fast_task());
  RelocateTask task(model);
  const auto start = episode_start({}, 3, 0);
  Path path;
  run_episode(
      task, start, 5, [](int, const PolicyInput&) { return RelocateAction::Constant(0.1).eval(); },
      &path);
  ASSERT_EQ(path.positions.cols(), 6);
  EXPECT_EQ(path.positions.topRows(kRelocateJoints), path.observations.topRows(kRelocateJoints));
  EXPECT_EQ(path.positions.col(5), task.positions());
}

TEST(Rollout, ADivergingEpisodeEndsFlaggedAndTheOthersGoOn) {
  const auto model = make_model(fast_task());
  EpisodeOptions options;
  options.horizon = 30;
  const auto episodes = rollout(model, BreakingPolicy(), options, 1, 3, 1);
  for (const Episode& episode : episodes) {
    EXPECT_TRUE(episode.diverged);
    EXPECT_LT(episode.steps, 30);
    EXPECT_TRUE(std::isfinite(episode.total));
    EXPECT_TRUE(std::isinf(episode.distance));
  }
  EXPECT_EQ(summarize(episodes).diverged, 3U);
  EXPECT_EQ(summarize(episodes).success_10cm, 0);
}

TEST(Rollout, APathHoldsWhatHappened) {
  const auto model = make_model(fast_task());
  const auto policy = small_network(2);
  RelocateTask task(model);
  Path path;
  const auto episode = run_episode(
      task, episode_start({}, 1, 0), 8,
      [&](int, const PolicyInput& input) { return policy.act(input); }, &path);
  EXPECT_EQ(path.rewards.size(), 8);
  EXPECT_EQ(path.observations.cols(), 9);
  EXPECT_NEAR(path.rewards.sum(), episode.total, 1e-12);
  EXPECT_EQ(path.observations.col(8), task.observation());
  for (int i = 0; i < 8; ++i) {
    EXPECT_LT((path.actions.col(i) - policy.mean(path.observations.col(i))).norm(), 1e-12);
  }
}

TEST(Rollout, StartsDependOnSeedAndIndexOnly) {
  EpisodeOptions options;
  options.scale_high = 1;
  const auto start = episode_start(options, 5, 3);
  EXPECT_EQ(episode_start(options, 5, 3).target, start.target);
  EXPECT_NE(episode_start(options, 5, 4).target, start.target);
  EXPECT_NE(episode_start(options, 6, 3).target, start.target);
  options.scale_low = 2;
  EXPECT_THROW(episode_start(options, 5, 3), BadInput);
}

TEST(Rollout, SummaryCountsSuccesses) {
  std::vector<Episode> episodes(4);
  const double distances[] = {0.01, 0.03, 0.07, 0.5};
  for (std::size_t i = 0; i < 4; ++i) {
    episodes[i].distance = distances[i];
    episodes[i].total = static_cast<double>(i);
    episodes[i].steps_within_5cm = i == 0 ? 26 : 25;
  }
  const auto summary = summarize(episodes);
  EXPECT_EQ(summary.success_10cm, 0.75);
  EXPECT_EQ(summary.success_5cm, 0.5);
  EXPECT_EQ(summary.success_2cm, 0.25);
  EXPECT_EQ(summary.success_steady, 0.25);
  EXPECT_EQ(summary.mean, 1.5);
  EXPECT_THROW(summarize({}), BadInput);
}

TEST(Rollout, OneEpisodeHasNoInterval) {
  EXPECT_FALSE(summarize(std::vector<Episode>(1)).ci95);
  EXPECT_TRUE(summarize(std::vector<Episode>(2)).ci95);
}

TEST(Rollout, AnObservationPeriodOfNoStepIsRefused) {
  EpisodeOptions options;
  options.observation_period = 0.004;
  EXPECT_THROW(episode_start(options, 5, 3), BadInput);
  options.observation_period = 0.006;
  EXPECT_EQ(episode_start(options, 5, 3).observation_period, 1);
}

TEST(Rollout, KnowsItsObjects) {
  for (const char* object : {"mug", "box", "bottle"}) {
    TaskOptions options = fast_task();
    options.object = object;
    EXPECT_GT(make_model(options).object_mass(), 0.2) << object;
  }
  TaskOptions options;
  options.object = "/nowhere/thing.ply";
  EXPECT_THROW(make_model(options), BadInput);
  options = {};
  options.solver = "magic";
  EXPECT_THROW(make_model(options), BadInput);
}

/// A policy, and the return for which it is known, less two standard errors of the episodes here.
struct KnownPolicy {
  std::filesystem::path file;
  double min_return;
  std::size_t episodes;
};

/// Ours has 4870 +- 302 in 300 episodes. That this is the published task shows in what its authors'
/// policy earns in it: 3744 +- 595, and hardly a start is failed.
std::vector<KnownPolicy> known_policies() {
  std::vector<KnownPolicy> known{{asset("models/relocate-best.json"), 4735, 20}};
  if (const auto published = real_data("relocate_mug_published_policy.json")) {
    known.push_back({*published, 3600, 60});
  }
  return known;
}

void expect_the_known_return(const KnownPolicy& known, const TaskOptions& task,
                             double success = 0.98) {
  const auto policy = load_policy(known.file);
  const auto summary = summarize(rollout(make_model(task), *policy, {}, 9000, known.episodes, 1));
  EXPECT_GE(summary.mean, known.min_return) << known.file << " " << task.object;
  EXPECT_GE(summary.success_5cm, success) << known.file << " " << task.object;
}

TEST(Rollout, APolicyEarnsWhatItIsKnownFor) {
  for (const KnownPolicy& known : known_policies()) expect_the_known_return(known, {});
}

/// Ours is wider than the mug that it was trained on; the YCB mug, where it is there, hardly.
TEST(Rollout, APolicyCarriesAMeshThatItWasNotTrainedOn) {
  const TemporaryFolder folder;
  geometry::save_ply(folder.path() / "mug.ply", geometry::mug_mesh());
  KnownPolicy ours = known_policies().front();
  ours.min_return *= 0.9;
  TaskOptions task;
  task.object = (folder.path() / "mug.ply").string();
  expect_the_known_return(ours, task, 0.9);
  const auto mesh = real_data("ycb/025_mug.ply");
  if (!mesh) return;
  task.object = "ycb-mug:" + mesh->string();
  for (KnownPolicy known : known_policies()) {
    known.min_return *= 0.95;
    expect_the_known_return(known, task);
  }
}

TEST(Rollout, ErrorsOfTheSensorsLeaveTheStartsAsTheyAre) {
  EpisodeOptions options;
  const auto start = episode_start(options, 5, 3);
  EXPECT_EQ(start.object_bias.norm(), 0);
  options.object_bias = 0.01;
  options.encoder_noise = 1e-4;
  const auto biased = episode_start(options, 5, 3);
  EXPECT_EQ(biased.target, start.target);
  EXPECT_EQ(biased.object, start.object);
  EXPECT_NEAR(biased.object_bias.norm(), 0.01, 1e-12);
  EXPECT_NE(episode_start(options, 5, 4).object_bias, biased.object_bias);
}

TEST(Rollout, DrawsTheShareOfStartsAtTheEndsThatIsAskedFor) {
  EpisodeOptions options;
  options.scale_high = 1;
  options.at_ends = 0.5;
  int low = 0, high = 0;
  for (std::size_t i = 0; i < 400; ++i) {
    const double x = episode_start(options, 5, i).object.x();  // gives the scale
    low += x == 0.15 * 0.25 - 0.1;
    high += x == 0.15 * 1.0 - 0.1;
  }
  EXPECT_NEAR(low, 100, 35);  // 4 standard deviations
  EXPECT_NEAR(high, 100, 35);
}

}  // namespace
}  // namespace palpate::relocate
