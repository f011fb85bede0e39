// SPDX-License-Identifier: Apache-2.0
#include "palpate/estimation/event_log.hpp"

#include <gtest/gtest.h>

namespace palpate::estimation {
namespace {

EventLog log_of(std::vector<EventLog::Moment> moments) {
  EventLog log;
  log.readings.resize(moments.empty() ? 1 : moments.back().reading + 10);
  log.moments = std::move(moments);
  return log;
}

TEST(EventLog, AnObjectHangsFromTheLiftUntilItIsPutDown) {
  const EventLog log =
      log_of({{TouchEvent::closed, 3}, {TouchEvent::held, 6}, {TouchEvent::placed, 9}});
  for (const std::size_t at : {0, 3, 5, 9, 15}) EXPECT_FALSE(log.hangs_at(at)) << at;
  for (const std::size_t at : {6, 7, 8}) EXPECT_TRUE(log.hangs_at(at)) << at;
}

TEST(TouchEvent, SomeEndAGuardedMoveAndSomeAreGrasps) {
  EXPECT_TRUE(ends_guarded_move(TouchEvent::touched));
  EXPECT_TRUE(ends_guarded_move(TouchEvent::missed));
  EXPECT_FALSE(ends_guarded_move(TouchEvent::guarded_move));
  EXPECT_TRUE(is_grasp(TouchEvent::closed));
  EXPECT_TRUE(is_grasp(TouchEvent::held));
  EXPECT_FALSE(is_grasp(TouchEvent::released));
}

TEST(EventLog, WhatHungBeforeTheHandLetGoHangsNoMore) {
  EXPECT_FALSE(log_of({{TouchEvent::held, 2}, {TouchEvent::released, 4}}).hangs_at(6));
  EXPECT_FALSE(log_of({{TouchEvent::held, 2}, {TouchEvent::opened, 4}}).hangs_at(6));
  EXPECT_TRUE(log_of({{TouchEvent::held, 2}, {TouchEvent::probed, 4}}).hangs_at(6));
}

TEST(EventLog, MomentsOfAKindAreCountedSinceTheReleaseAndAcrossAnOpening) {
  const EventLog log = log_of({{TouchEvent::probed, 1},
                               {TouchEvent::released, 2},
                               {TouchEvent::probed, 3},
                               {TouchEvent::opened, 4},
                               {TouchEvent::probed, 5}});
  EXPECT_EQ(log.count(TouchEvent::probed), 2U);
  EXPECT_EQ(log.count(TouchEvent::opened), 1U);
  EXPECT_EQ(log.count(TouchEvent::held), 0U);
}

TEST(EventLog, TheLatestMomentOfAKindIsSinceTheRelease) {
  const EventLog log =
      log_of({{TouchEvent::closed, 1}, {TouchEvent::released, 2}, {TouchEvent::closed, 5}});
  EXPECT_EQ(log.at(TouchEvent::closed), 5u);
  EXPECT_EQ(log.all(TouchEvent::closed), std::vector<std::size_t>{5});
  EXPECT_FALSE(log.at(TouchEvent::held));
}

}  // namespace
}  // namespace palpate::estimation
