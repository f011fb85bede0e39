// SPDX-License-Identifier: Apache-2.0
#include "tactile/normals/lift_detector.hpp"

#include <gtest/gtest.h>

#include <algorithm>

namespace palpate::tactile {
namespace {

constexpr double kForget = 0.5;  // s

FingerSample sample_at(double time, double x, SampleFlag flag = SampleFlag::gap) {
  FingerSample sample{.time = time, .p = {x, 0, 0}, .f = {0, 0, -1}, .tip_normal = {}, .flags = {}};
  sample.flags.set(flag);
  return sample;
}

/// Slides at 20 mm/s for 20 samples, and returns the time of the last.
double slide(LiftDetector& lifts, double period) {
  for (int i = 0; i < 20; ++i) {
    EXPECT_EQ(lifts.begins(sample_at(period * i, 0.02 * period * i)), i == 0) << period << ' ' << i;
  }
  return 19 * period;
}

TEST(LiftDetector, AGapOfAFewPeriodsIsALift) {
  for (const double period : {0.001, 0.01, 0.03, 0.1}) {
    LiftDetector lifts(kForget);
    const double end = slide(lifts, period);
    EXPECT_FALSE(lifts.begins(sample_at(end + 2 * period, 0.02 * (end + 2 * period)))) << period;
    const double later = end + 2 * period + std::max(0.06, 4 * period);
    EXPECT_TRUE(lifts.begins(sample_at(later, 0.02 * later))) << period;
  }
}

TEST(LiftDetector, AClockThatWasSetBackIsALift) {
  LiftDetector lifts(kForget);
  const double end = slide(lifts, 0.01);
  EXPECT_TRUE(lifts.begins(sample_at(0, 0.02 * end)));
  EXPECT_FALSE(lifts.begins(sample_at(0.01, 0.02 * (end + 0.01))));
}

TEST(LiftDetector, SamplesWithoutContactOrForceAreALiftUnlessItIsABounce) {
  for (const SampleFlag flag : {SampleFlag::no_contact, SampleFlag::no_force}) {
    LiftDetector lifts(kForget);
    const double end = slide(lifts, 0.01);
    EXPECT_FALSE(lifts.begins(sample_at(end + 0.01, 0, flag)));
    EXPECT_FALSE(lifts.begins(sample_at(end + 0.02, 0.02 * end)));
    EXPECT_FALSE(lifts.begins(sample_at(end + 0.03, 0, flag)));
    EXPECT_TRUE(lifts.begins(sample_at(end + 0.09, 0.02 * end)));
  }
}

TEST(LiftDetector, AfterASampleWithoutContactAnotherPlaceIsAnotherContact) {
  LiftDetector lifts(kForget);
  const double end = slide(lifts, 0.01);
  lifts.begins(sample_at(end + 0.01, 0, SampleFlag::no_contact));
  EXPECT_TRUE(lifts.begins(sample_at(end + 0.02, 0.02 * end + 0.02)));
}

TEST(LiftDetector, AnOutlierOfThePointIsNone) {
  LiftDetector lifts(kForget);
  const double end = slide(lifts, 0.01);
  EXPECT_FALSE(lifts.begins(sample_at(end + 0.01, 0.02 * end + 0.01)));
  EXPECT_FALSE(lifts.begins(sample_at(end + 0.02, 0.02 * end)));
}

TEST(LiftDetector, RepeatedSamplesAreNone) {
  LiftDetector lifts(kForget);
  const double end = slide(lifts, 0.1);
  EXPECT_FALSE(lifts.begins(sample_at(end + 0.1, 0, SampleFlag::repeated)));
  EXPECT_FALSE(lifts.begins(sample_at(end + 0.2, 0.02 * end)));
}

}  // namespace
}  // namespace palpate::tactile
