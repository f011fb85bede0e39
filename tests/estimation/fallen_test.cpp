// SPDX-License-Identifier: Apache-2.0
#include "estimation/fallen.hpp"

#include <gtest/gtest.h>

namespace palpate::estimation {
namespace {

TEST(OfFallen, LooksWiderAndWithATiltThatNoStablePoseHas) {
  EstimationOptions options;
  options.resting_tilt_sigma = 0.02;
  options.resting_half_width = 0.03;
  const auto near = of_fallen(options, {0, 0});
  EXPECT_GT(near.resting_tilt_sigma, options.resting_tilt_sigma);
  EXPECT_GT(near.resting_half_width, options.resting_half_width);
  const auto far = of_fallen(options, {0.1, -0.2});
  EXPECT_NEAR(far.resting_half_width - near.resting_half_width, 0.2, 1e-12);
}

TEST(OfFallen, NeverLooksCloserThanAsked) {
  EstimationOptions options;
  options.resting_tilt_sigma = 0.5;
  options.resting_half_width = 1.0;
  const auto fallen = of_fallen(options, {0, 0});
  EXPECT_EQ(fallen.resting_tilt_sigma, options.resting_tilt_sigma);
  EXPECT_EQ(fallen.resting_half_width, options.resting_half_width);
}

}  // namespace
}  // namespace palpate::estimation
