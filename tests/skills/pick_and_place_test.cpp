// SPDX-License-Identifier: Apache-2.0
#include "palpate/skills/place/pick_and_place.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

#include "evaluation/mishap.hpp"
#include "palpate/core/error.hpp"

namespace palpate::skills {
namespace {

TEST(PlaceStrategy, AreWhatTheirNamesSay) {
  for (const PlaceStrategy strategy : {PlaceStrategy::automatic, PlaceStrategy::wrist,
                                       PlaceStrategy::fingers, PlaceStrategy::regrasp}) {
    EXPECT_EQ(place_strategy(to_string(strategy)), strategy) << to_string(strategy);
  }
  EXPECT_EQ(place_strategy(PlaceOptions().strategy), PlaceStrategy::automatic);
}

TEST(PlaceStrategy, OtherWordsAreNamed) {
  for (const std::string word : {"teleport", "none"}) {
    try {
      place_strategy(word);
      ADD_FAILURE() << word;
    } catch (const BadInput& error) {
      EXPECT_NE(std::string(error.what()).find(word), std::string::npos) << error.what();
    }
  }
}

TEST(PickAndPlace, WhatFellOnTheWayIsFoundByTouchAndPickedAgain) {
  evaluation::Mishap mishap;
  mishap.options.place.strategy = "wrist";
  const auto outcome = pick_and_place(mishap.robot, mishap.task(), mishap.observer);
  ASSERT_TRUE(outcome.picked.held);  // found where it fell, and held again
  EXPECT_TRUE(outcome.picked.fallen);
  const auto count = [&](std::string_view name) {
    return std::count_if(outcome.picked.phases.begin(), outcome.picked.phases.end(),
                         [&](const auto& phase) { return phase.name == name; });
  };
  EXPECT_EQ(count("clear"), 1);
  EXPECT_GE(count("height_probe"), 2);
  ASSERT_TRUE(outcome.place);
  EXPECT_EQ(outcome.place->status, PlaceStatus::placed);
  EXPECT_LT(mishap.off(*outcome.place), 0.03);
  EXPECT_EQ(outcome.strategy.strategy, PlaceStrategy::wrist);  // reported of the last hold, too
  EXPECT_EQ(outcome.strategy.reason, "asked for");
}

std::vector<std::string> names_of(const std::vector<PhaseReport>& phases) {
  std::vector<std::string> names;
  for (const PhaseReport& phase : phases) names.push_back(phase.name);
  return names;
}

TEST(PickAndPlace, AFaultOfAPlacingKeepsThePhasesAndNoPose) {
  evaluation::Mishap mishap;
  mishap.options.place.strategy = "regrasp";
  PickResult held;
  int placings = 0;
  const PhaseObserver observer{[&](std::string_view phase, double) {
                                 if (phase == "transport")
                                   mishap.robot.make_safe(Fault::excess_force, "50 N");
                               },
                               {},
                               [&](const PickResult& picked) { held = picked; },
                               [&](const PlaceResult&) { ++placings; }};
  const auto outcome = pick_and_place(mishap.robot, mishap.task(), observer);
  ASSERT_TRUE(held.held);
  EXPECT_EQ(outcome.picked.fault.fault, Fault::excess_force);
  EXPECT_EQ(outcome.picked.fault.detail, "50 N");
  EXPECT_FALSE(outcome.picked.held);
  EXPECT_TRUE(outcome.picked.estimate.posterior.modes.empty());
  EXPECT_FALSE(outcome.place);
  EXPECT_EQ(placings, 0);
  EXPECT_EQ(outcome.picked.failed_phase, "transport");
  auto expected = names_of(held.phases);
  expected.insert(expected.end(), {"plan-goal", "transport"});
  EXPECT_EQ(names_of(outcome.picked.phases), expected);
  EXPECT_EQ(outcome.picked.phases.back().status, PhaseStatus::fault);
  EXPECT_EQ(outcome.strategy.regrasp, RegraspStatus::stopped);
  ASSERT_EQ(outcome.strategy.rounds.size(), 1u);
  EXPECT_EQ(outcome.strategy.rounds.front().place, PlaceStatus::stopped);

  // By itself a placing says the same of a robot that has stopped.
  const PlaceResult placed = place(mishap.robot, mishap.task(), held, observer);
  EXPECT_EQ(placed.status, PlaceStatus::stopped);
  EXPECT_EQ(to_string(placed.status), "stopped");
  EXPECT_FALSE(was_put_back(placed.status));
  EXPECT_EQ(placed.fault.fault, Fault::excess_force);
  EXPECT_EQ(names_of(placed.phases), std::vector<std::string>{"plan-goal"});
  EXPECT_EQ(placed.failed_phase, "plan-goal");
  EXPECT_FALSE(placed.T_world_placed);
  EXPECT_EQ(placings, 0);

  // So does regrasping, which ends after a pick that does not begin.
  const RegraspResult result = regrasp(mishap.robot, mishap.task(), observer);
  EXPECT_EQ(result.status, RegraspStatus::stopped);
  EXPECT_EQ(to_string(result.status), "stopped");
  ASSERT_EQ(result.rounds.size(), 1u);
  EXPECT_EQ(result.rounds.front().pick.fault.fault, Fault::excess_force);
}

}  // namespace
}  // namespace palpate::skills
