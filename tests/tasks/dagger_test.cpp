// SPDX-License-Identifier: Apache-2.0
#include "palpate/tasks/relocate/training/dagger.hpp"

#include <gtest/gtest.h>

#include "tasks/policies.hpp"

namespace palpate::relocate {
namespace {

RelocateModel fast_model() {
  TaskOptions options;
  options.solver = "fast";
  return make_model(options);
}

DaggerOptions small() {
  DaggerOptions options;
  options.hidden = 5;
  options.rounds = 2;
  options.episodes = 4;
  options.samples = 200;
  options.episode.horizon = 5;
  return options;
}

TEST(Dagger, EveryRoundAddsItsFramesWithTheExpertsAnswers) {
  const auto model = fast_model();
  const auto expert = structured(false);
  DaggerState state;
  dagger_round(state, model, expert, small(), 3, 1);
  EXPECT_EQ(state.round, 1);
  EXPECT_EQ(state.observations.cols(), 20);  // 4 episodes of 5 steps
  ASSERT_TRUE(state.student);
  dagger_round(state, model, expert, small(), 3, 1);
  EXPECT_EQ(state.observations.cols(), 40);
  ASSERT_EQ(state.actions.cols(), 40);
  EXPECT_LE(state.actions.cwiseAbs().maxCoeff(), 1);
  EXPECT_EQ(policy_from(*state.student)->record().sizes, (std::vector<int>{39, 5, 5, 30}));
}

TEST(Dagger, IsTheSameForAnyNumberOfThreads) {
  const auto model = fast_model();
  const auto expert = structured(false);
  DaggerState one, three;
  for (int round = 0; round < 2; ++round) {
    dagger_round(one, model, expert, small(), 3, 1);
    dagger_round(three, model, expert, small(), 3, 3);
  }
  EXPECT_EQ(one.observations, three.observations);
  EXPECT_EQ(one.student->arrays, three.student->arrays);
}

}  // namespace
}  // namespace palpate::relocate
