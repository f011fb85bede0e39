// SPDX-License-Identifier: Apache-2.0
#include "palpate/evaluation/belief_recorder.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "evaluation/quick_options.hpp"
#include "palpate/core/angle.hpp"

namespace palpate::evaluation {
namespace {

constexpr std::uint64_t kSeed = 9;

struct BelievedPick {
  std::vector<recording::BeliefRecord> beliefs;
  std::vector<double> observed;  // times at which the observer was called
  Trial trial;
};

BelievedPick believed_pick() {
  TrialOptions options = quick_place_options();
  options.place.target.clear();
  const geometry::ObjectModel box(geometry::load_known_object("box"));
  const simulation::World world(box.object(), options.world, kSeed);
  BelievedPick pick;
  BeliefRecorder recorder(box, world.hand_model(), {options.pick_options(), {}}, kSeed,
                          [&](const auto& belief) { pick.observed.push_back(belief.time); });
  pick.trial = run_trial(box, options, kSeed, &recorder);
  pick.beliefs = recorder.finish();
  return pick;
}

const BelievedPick& first_pick() {
  static const BelievedPick pick = believed_pick();
  return pick;
}

double mass(const recording::BeliefRecord& belief) {
  double sum = 0;
  for (const auto& pose : belief.poses) sum += pose.probability;
  return sum;
}

TEST(BeliefRecorder, GoesFromThePriorThroughTouchesToTheHand) {
  const BelievedPick& pick = first_pick();
  ASSERT_GT(pick.beliefs.size(), 5U);
  EXPECT_EQ(pick.beliefs.front().source, "prior");
  EXPECT_LT(mass(pick.beliefs.front()), 0.1);  // each of its poses stands for its ball alone
  EXPECT_TRUE(pick.beliefs.back().in_hand);
  const auto is_online = [](const auto& belief) { return belief.source == "online"; };
  EXPECT_TRUE(std::ranges::any_of(pick.beliefs, is_online));
  const double at_first = recording::entropy(pick.beliefs.front());
  double before = 0;
  for (const auto& belief : pick.beliefs) {
    EXPECT_LE(recording::entropy(belief), at_first);
    EXPECT_GE(belief.time, before);
    EXPECT_LE(mass(belief), 1 + 1e-9);
    EXPECT_FALSE(belief.poses.empty()) << "at " << belief.time;
    before = belief.time;
  }
  ASSERT_EQ(pick.observed.size(), pick.beliefs.size());
  EXPECT_EQ(pick.observed.back(), pick.beliefs.back().time);
}

TEST(BeliefRecorder, WhatHangsInTheHandStaysKnown) {
  const BelievedPick& pick = first_pick();
  ASSERT_TRUE(pick.trial.metrics.pose_ok);
  const auto online = std::find_if(pick.beliefs.rbegin(), pick.beliefs.rend(),
                                   [](const auto& belief) { return belief.source == "online"; });
  ASSERT_NE(online, pick.beliefs.rend());
  ASSERT_FALSE(online->poses.empty());
  EXPECT_GT(online->poses.front().probability, 0.7);
  const auto error = localization::pose_error(online->poses.front().T_world_object,
                                              pick.trial.metrics.T_world_object,
                                              geometry::load_known_object("box").symmetries);
  EXPECT_LT(error.rotation, 5 * kDegree);
  EXPECT_LT(error.translation, 0.01);
}

TEST(BeliefRecorder, BelievesTheSameHoweverItsThreadIsDelayed) {
  const BelievedPick &one = first_pick(), two = believed_pick();
  ASSERT_EQ(one.beliefs.size(), two.beliefs.size());
  for (std::size_t i = 0; i < one.beliefs.size(); ++i) {
    ASSERT_EQ(one.beliefs[i].poses.size(), two.beliefs[i].poses.size()) << i;
    for (std::size_t k = 0; k < one.beliefs[i].poses.size(); ++k) {
      EXPECT_EQ(one.beliefs[i].poses[k].probability, two.beliefs[i].poses[k].probability);
      EXPECT_EQ(one.beliefs[i].poses[k].T_world_object.matrix(),
                two.beliefs[i].poses[k].T_world_object.matrix());
    }
  }
}

}  // namespace
}  // namespace palpate::evaluation
