// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "tactile/biotac/rest_tracker.hpp"
#include "tactile/biotac_logs.hpp"

namespace palpate::tactile {
namespace {

constexpr double kPeriod = 1.0 / 60;

BiotacChannels counts(double pressure, double electrodes = 3200) {
  BiotacChannels channels = BiotacChannels::Constant(electrodes);
  channels[0] = pressure;
  return channels;
}

TEST(BiotacRestTracker, KnowsRestAfterTenQuietFrames) {
  BiotacRestTracker tracker;
  for (int i = 0; i < 9; ++i) EXPECT_FALSE(tracker.step(i * kPeriod, counts(2410))) << i;
  const auto& rest = tracker.step(9 * kPeriod, counts(2410));
  ASSERT_TRUE(rest);
  EXPECT_EQ(*rest, counts(2410));
}

TEST(BiotacRestTracker, KeepsRestDuringATouchAndFollowsADrift) {
  BiotacRestTracker tracker;
  int i = 0;
  for (; i < 60; ++i) tracker.step(i * kPeriod, counts(2410));
  for (; i < 120; ++i) tracker.step(i * kPeriod, counts(2700, 2900));
  EXPECT_NEAR((*tracker.step(i * kPeriod, counts(2700, 2900)) - counts(2410)).norm(), 0, 1e-9);
  for (int k = 0; k < 60; ++k) tracker.step((++i) * kPeriod, counts(2410 + 0.02 * k, 3210));
  const auto rest = *tracker.step((++i) * kPeriod, counts(2411, 3210));
  EXPECT_NEAR(rest[0], 2411, 0.5);
  EXPECT_NEAR(rest[5], 3210, 0.1);
}

TEST(BiotacRestTracker, TakesBackWhatWasATouch) {
  BiotacRestTracker tracker;
  for (int i = 0; i < 30; ++i) tracker.step(i * kPeriod, counts(2500, 3000));  // a steady touch
  for (int i = 30; i < 35; ++i) tracker.step(i * kPeriod, counts(2410));
  EXPECT_FALSE(tracker.step(35 * kPeriod, counts(2410)));
  for (int i = 36; i < 50; ++i) tracker.step(i * kPeriod, counts(2410));
  EXPECT_EQ(*tracker.step(50 * kPeriod, counts(2410)), counts(2410));
}

TEST(BiotacSignals, CausallyAFrameDoesNotDependOnLaterOnes) {
  auto log = made_up_log(3, 2);
  const auto whole = biotac_signals(log, BiotacRest::causal);
  const std::size_t cut = 250;  // in the first touch
  log.time.resize(cut);
  log.channels.resize(cut);
  log.normals.resize(cut);
  const auto part = biotac_signals(log, BiotacRest::causal);
  for (std::size_t i = 0; i < cut; ++i) {
    EXPECT_EQ(part.flags[i], whole.flags[i]) << i;
    if (!part.rests[i].allFinite()) continue;
    EXPECT_EQ(part.changes[i], whole.changes[i]) << i;
  }
}

TEST(BiotacSignals, CausallyALogThatStartsInContactHasNoRestAtFirst) {
  auto log = made_up_log(3, 3);
  log.time.erase(log.time.begin(), log.time.begin() + 200);  // within the first touch
  log.channels.erase(log.channels.begin(), log.channels.begin() + 200);
  log.normals.erase(log.normals.begin(), log.normals.begin() + 200);
  const auto signals = biotac_signals(log, BiotacRest::causal);
  for (std::size_t i = 0; i < 80; ++i) EXPECT_FALSE(biotac_usable(signals.flags[i])) << i;
  std::size_t usable = 0;
  for (const unsigned flags : signals.flags) usable += biotac_usable(flags);
  EXPECT_GT(usable, 250u);  // of the two touches after it
}

}  // namespace
}  // namespace palpate::tactile
