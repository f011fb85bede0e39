// SPDX-License-Identifier: Apache-2.0
#include "palpate/learning/training/cem.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "palpate/core/error.hpp"

namespace palpate::learning {
namespace {

const Eigen::Vector3d kBest(1, -2, 0.5);

std::vector<double> closeness(const std::vector<Eigen::VectorXd>& candidates) {
  std::vector<double> scores;
  for (const auto& candidate : candidates) scores.push_back(-(candidate - kBest).squaredNorm());
  return scores;
}

CemState start() { return {0, Eigen::Vector3d::Zero(), Eigen::Vector3d::Ones()}; }

TEST(Cem, FindsTheBestOfASmoothFunction) {
  CemState state = start();
  for (int i = 0; i < 30; ++i) cem_generation(state, closeness, {}, 1);
  EXPECT_LT((state.mean - kBest).norm(), 0.02);
  EXPECT_EQ(state.generation, 30);
}

TEST(Cem, GoesOnAsIfItHadNotBeenInterrupted) {
  CemState whole = start(), part = start();
  for (int i = 0; i < 6; ++i) cem_generation(whole, closeness, {}, 4);
  for (int i = 0; i < 3; ++i) cem_generation(part, closeness, {}, 4);
  CemState resumed = part;
  for (int i = 0; i < 3; ++i) cem_generation(resumed, closeness, {}, 4);
  EXPECT_EQ(resumed.mean, whole.mean);
  EXPECT_EQ(resumed.spread, whole.spread);
}

TEST(Cem, MayBeAskedAndTold) {
  CemState whole = start(), part = start();
  for (int i = 0; i < 4; ++i) {
    cem_generation(whole, closeness, {}, 4);
    const auto candidates = cem_candidates(part, {}, 4);
    EXPECT_EQ(candidates.front(), part.mean);
    EXPECT_EQ(candidates, cem_candidates(part, {}, 4));
    cem_update(part, candidates, closeness(candidates), {});
  }
  EXPECT_EQ(part.mean, whole.mean);
  EXPECT_EQ(part.spread, whole.spread);
  const std::vector<Eigen::VectorXd> few = {part.mean};
  EXPECT_THROW(cem_update(part, few, {1}, {}), BadInput);
  EXPECT_THROW(cem_update(part, cem_candidates(part, {}, 4), {1}, {}), BadInput);
}

TEST(Cem, ACandidateWithoutAScoreIsNotElite) {
  CemState state = start();
  const auto broken = [](const std::vector<Eigen::VectorXd>& candidates) {
    auto scores = closeness(candidates);
    for (std::size_t i = 0; i < scores.size(); i += 2) {
      scores[i] = std::numeric_limits<double>::quiet_NaN();
    }
    return scores;
  };
  for (int i = 0; i < 30; ++i) cem_generation(state, broken, {}, 1);
  EXPECT_LT((state.mean - kBest).norm(), 0.05);
}

TEST(Cem, RejectsWhatCannotBeSearched) {
  CemState state = start();
  EXPECT_THROW(cem_generation(
                   state, [](const auto& c) { return std::vector<double>(c.size(), NAN); }, {}, 1),
               BadInput);
  EXPECT_THROW(cem_generation(
                   state, [](const auto&) { return std::vector<double>(1, 0); }, {}, 1),
               BadInput);
  CemOptions options;
  options.elite = options.population + 1;
  EXPECT_THROW(cem_generation(state, closeness, options, 1), BadInput);
  state.spread.resize(2);
  EXPECT_THROW(cem_generation(state, closeness, {}, 1), BadInput);
}

}  // namespace
}  // namespace palpate::learning
