// SPDX-License-Identifier: Apache-2.0
#include "palpate/skills/place/pick_and_place.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "evaluation/mishap.hpp"
#include "palpate/core/error.hpp"

namespace palpate::skills {
namespace {

TEST(PlaceStrategy, AreWhatTheirNamesSay) {
  for (const PlaceStrategy strategy : {PlaceStrategy::automatic, PlaceStrategy::wrist,
                                       PlaceStrategy::fingers, PlaceStrategy::regrasp}) {
    PlaceOptions options;
    options.strategy = to_string(strategy);
    EXPECT_EQ(place_strategy(options), strategy) << options.strategy;
  }
  EXPECT_EQ(place_strategy({}), PlaceStrategy::automatic);
}

TEST(PlaceStrategy, OtherWordsAreNamed) {
  PlaceOptions options;
  options.strategy = "teleport";
  try {
    place_strategy(options);
    FAIL();
  } catch (const BadInput& error) {
    EXPECT_NE(std::string(error.what()).find("teleport"), std::string::npos) << error.what();
  }
}

TEST(PickAndPlace, WhatFellOnTheWayIsFoundByTouchAndPickedAgain) {
  evaluation::Mishap mishap;
  mishap.options.place.strategy = "wrist";
  const auto course = pick_and_place(mishap.robot, mishap.task(), mishap.observer);
  ASSERT_TRUE(course.picked.held);  // found where it fell, and held again
  EXPECT_TRUE(course.picked.fallen);
  const auto count = [&](std::string_view name) {
    return std::count_if(course.picked.phases.begin(), course.picked.phases.end(),
                         [&](const auto& phase) { return phase.name == name; });
  };
  EXPECT_EQ(count("clear"), 1);
  EXPECT_GE(count("height_probe"), 2);
  ASSERT_TRUE(course.place);
  EXPECT_EQ(course.place->status, PlaceStatus::placed);
  EXPECT_LT(mishap.off(*course.place), 0.03);
  EXPECT_EQ(course.strategy.strategy, PlaceStrategy::wrist);  // reported of the last hold, too
  EXPECT_EQ(course.strategy.reason, "asked for");
}

}  // namespace
}  // namespace palpate::skills
