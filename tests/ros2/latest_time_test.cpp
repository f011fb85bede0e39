// SPDX-License-Identifier: Apache-2.0
#include "palpate/ros2/latest_time.hpp"

#include <gtest/gtest.h>

namespace palpate::ros2 {
namespace {

constexpr std::uint64_t kMs = 1'000'000;     // ns
constexpr std::uint64_t kNow = 5'000 * kMs;  // of the latest message before
constexpr int kEnough = 20;                  // early messages in a row

LatestTime at_now() {
  LatestTime latest;
  EXPECT_EQ(latest.take(kNow), TimeOrder::later);
  return latest;
}

TEST(LatestTime, WhatIsNotLaterIsLate) {
  LatestTime latest = at_now();
  EXPECT_EQ(latest.take(kNow), TimeOrder::late);
  EXPECT_EQ(latest.take(kNow - kMs), TimeOrder::late);
  EXPECT_EQ(latest.take(kNow + kMs), TimeOrder::later);
  EXPECT_EQ(latest.time(), kNow + kMs);
}

TEST(LatestTime, ManyEarlyOnesThatFollowOneAnotherAreOfAClockSetBack) {
  LatestTime latest = at_now();
  for (int i = 1; i < kEnough; ++i) {
    EXPECT_EQ(latest.take(i * kMs), TimeOrder::late) << i;
    EXPECT_EQ(latest.time(), kNow);
  }
  EXPECT_EQ(latest.take(kEnough * kMs), TimeOrder::set_back);
  EXPECT_EQ(latest.time(), kEnough * kMs);
  EXPECT_EQ(latest.take((kEnough + 1) * kMs), TimeOrder::later);
}

TEST(LatestTime, OneThatIsLaterInBetweenShowsThatTheOthersWereLate) {
  LatestTime latest = at_now();
  for (int i = 1; i < kEnough; ++i) latest.take(i * kMs);
  EXPECT_EQ(latest.take(kNow + kMs), TimeOrder::later);
  EXPECT_EQ(latest.take(kEnough * kMs), TimeOrder::late);
}

TEST(LatestTime, EarlyOnesOfOneTimeOrALittleEarlySetNothingBack) {
  LatestTime latest = at_now();
  for (int i = 0; i < 3 * kEnough; ++i) {
    EXPECT_EQ(latest.take(kMs), TimeOrder::late);
    EXPECT_EQ(latest.take(kNow - 80 * kMs + i * kMs), TimeOrder::late);
  }
  EXPECT_EQ(latest.time(), kNow);
}

}  // namespace
}  // namespace palpate::ros2
