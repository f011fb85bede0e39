// SPDX-License-Identifier: Apache-2.0
#include "palpate/tasks/relocate/training/structured_search.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <optional>

#include "palpate/tasks/relocate/training/randomization.hpp"

namespace palpate::relocate {
namespace {

Episode episode(double total, double distance) {
  Episode e;
  e.total = total;
  e.distance = distance;
  return e;
}

TEST(StructuredSearch, AScoreCountsTheMeanTheWorstAndSuccess) {
  PolicySearchOptions options;
  options.worst = 0.25;
  options.success_bonus = 100;
  const std::vector<Episode> episodes = {episode(10, 0.01), episode(20, 0.3), episode(60, 0.019)};
  EXPECT_NEAR(search_score(episodes, options), 0.75 * 30 + 0.25 * 10 + 100 * 2.0 / 3, 1e-12);
  options.worst = 0;
  options.success_bonus = 0;
  EXPECT_NEAR(search_score(episodes, options), 30, 1e-12);
}

/// Candidates that hold still but for how they hold the fingers.
struct Search {
  Search() {
    TaskOptions task;
    task.solver = "fast";
    model.emplace(make_model(task));
    options.episode.horizon = 4;
    options.screening = 1;
    options.episodes = 2;
    const Eigen::VectorXd start = flatten(structured_start());
    for (int i = 0; i < 4; ++i) {
      candidates.push_back(start);
      candidates.back().head<3>().array() += 0.02 * i;
    }
  }

  std::vector<double> scores(int generation, int threads) const {
    const auto make = [&](const Eigen::VectorXd& x) {
      return StructuredPolicy(unflatten(x), model->action_center(), model->action_half_range(),
                              false);
    };
    const std::vector<RelocateModel> worlds = {*model};
    return search_scores(worlds, make, options, 6, generation, threads)(candidates);
  }

  std::optional<RelocateModel> model;
  PolicySearchOptions options;
  std::vector<Eigen::VectorXd> candidates;
};

TEST(StructuredSearch, ScoresAreTheSameForAnyNumberOfThreads) {
  const Search search;
  EXPECT_EQ(search.scores(0, 1), search.scores(0, 2));
  EXPECT_NE(search.scores(0, 1), search.scores(1, 1));  // other episodes
}

TEST(StructuredSearch, HalfIsGivenUpAfterTheScreeningAndRanksBelow) {
  const Search search;
  auto scores = search.scores(0, 1);
  std::sort(scores.begin(), scores.end());
  EXPECT_LT(scores[1], -1e5);
  EXPECT_GT(scores[2], -1e5);
}

TEST(StructuredSearch, EqualCandidatesScoreEqually) {
  Search search;
  search.options.episodes = 1;
  search.candidates.assign(3, search.candidates[1]);
  const auto scores = search.scores(2, 1);
  EXPECT_EQ(scores[0], scores[1]);
  EXPECT_EQ(scores[0], scores[2]);
}

TEST(StructuredSearch, EpisodesTakePlaceInAllWorlds) {
  RandomizationOptions options;
  TaskOptions task;
  task.solver = "fast";
  EXPECT_EQ(randomized_worlds(task, options).size(), 1U);
  options.friction_scale = 0.5;
  options.mass_scale = 2;
  options.size = 0.9;
  options.box = true;
  const auto worlds = randomized_worlds(task, options);
  ASSERT_EQ(worlds.size(), 5U);
  EXPECT_NEAR(worlds[2].object_mass(), 2 * worlds[0].object_mass(), 1e-12);
  std::vector<int> episodes(worlds.size());
  for (std::size_t i = 0; i < 500; ++i) ++episodes[world_of_episode(worlds.size(), 7, i)];
  for (const int count : episodes) EXPECT_NEAR(count, 100, 36);  // 4 standard deviations
}

TEST(StructuredSearch, FreeMemoryStretchesRingAndLittleFinger) {
  const auto freed = with_free_memory(structured_start());
  const Eigen::VectorXd change = flatten(freed) - flatten(structured_start());
  EXPECT_EQ((change.array() != 0).count(), 8);  // two joints of two fingers, open and closed
  EXPECT_LT(change.maxCoeff(), 0.01);
}

}  // namespace
}  // namespace palpate::relocate
