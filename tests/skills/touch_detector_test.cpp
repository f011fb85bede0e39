// SPDX-License-Identifier: Apache-2.0
#include "skills/motion/touch_detector.hpp"

#include <gtest/gtest.h>

namespace palpate::skills {
namespace {

constexpr double kForce = 0.1;  // N

TEST(TouchDetector, OneReadingOfTheForceIsATouch) {
  TouchDetector detector(kForce);
  EXPECT_FALSE(detector.update(0));
  EXPECT_TRUE(detector.update(1.01 * kForce));
}

TEST(TouchDetector, SoAreSeveralOfASmallerOne) {
  TouchDetector detector(kForce);
  int readings = 1;
  while (!detector.update(0.5 * kForce) && readings < 10) ++readings;
  EXPECT_EQ(readings, 3);
}

TEST(TouchDetector, AForceFarBelowIsNoneHoweverLongItLasts) {
  TouchDetector detector(kForce);
  for (int i = 0; i < 1000; ++i) ASSERT_FALSE(detector.update(0.15 * kForce));
}

TEST(TouchDetector, ForgetsAFirmTouchAtOnce) {
  TouchDetector detector(kForce);
  for (int i = 0; i < 100; ++i) detector.update(20 * kForce);
  EXPECT_FALSE(detector.update(0));
}

}  // namespace
}  // namespace palpate::skills
