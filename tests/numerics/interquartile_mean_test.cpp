// SPDX-License-Identifier: Apache-2.0
#include "palpate/numerics/interquartile_mean.hpp"

#include <gtest/gtest.h>

#include "palpate/core/error.hpp"

namespace palpate::numerics {
namespace {

TEST(InterquartileMean, IsThatOfSciPy) {  // stats.trim_mean(values, 0.25)
  EXPECT_NEAR(interquartile_mean(
                  {0.1, 0.2, 0.2, 0.3, 0.3, 0.4, 0.5, 0.6, 0.9, 1.5, 2.7, 6.1, 9.9, 14.0, 30.5}),
              1.4777777777777779, 1e-12);
  EXPECT_NEAR(interquartile_mean({3, 1, 2}), 2, 1e-12);
  EXPECT_NEAR(interquartile_mean({100, 2, 1, 4}), 3, 1e-12);
  EXPECT_THROW(interquartile_mean({}), BadInput);
}

TEST(InterquartileMean, ResamplesWithinEachStratum) {
  const RandomStream random(3);
  // Trainings that agree within their stratum leave nothing to chance, however far apart strata
  // are.
  const Interval sure = bootstrap_interquartile_mean({{1, 1, 1}, {9, 9, 9}}, 200, random);
  EXPECT_EQ(sure.low, 5);
  EXPECT_EQ(sure.high, 5);
  const Interval unsure = bootstrap_interquartile_mean({{1, 9, 1, 9, 1, 9}}, 2000, random);
  EXPECT_LT(unsure.low, 3);
  EXPECT_GT(unsure.high, 7);
  EXPECT_THROW(bootstrap_interquartile_mean({}, 10, random), BadInput);
  EXPECT_THROW(bootstrap_interquartile_mean({{1}, {}}, 10, random), BadInput);
}

TEST(InterquartileMean, AnIntervalHoldsTheTruthAboutAsOftenAsItSays) {
  RandomStream random(11);
  int held = 0;
  for (int trial = 0; trial < 300; ++trial) {
    std::vector<double> values(20);
    for (double& value : values) value = random.normal();
    const auto interval = bootstrap_interquartile_mean(
        {values}, 400, random.fork("trial", static_cast<std::uint64_t>(trial)));
    held += interval.low <= 0 && 0 <= interval.high;
  }
  EXPECT_NEAR(held / 300.0, 0.95, 0.06);  // percentile intervals of 20 values are a little short
}

}  // namespace
}  // namespace palpate::numerics
