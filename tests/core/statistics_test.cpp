// SPDX-License-Identifier: Apache-2.0
#include "palpate/core/statistics.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "core/error_message.hpp"

namespace palpate {
namespace {

TEST(Statistics, MeanAndStandardDeviation) {
  const std::vector<double> values = {2, 4, 4, 4, 5, 5, 7, 9};
  EXPECT_DOUBLE_EQ(mean(values), 5.0);
  EXPECT_DOUBLE_EQ(standard_deviation(values), std::sqrt(32.0 / 7));
  EXPECT_EQ(mean({3}), 3);
}

TEST(Statistics, StandardDeviationOfALargeOffset) {
  EXPECT_DOUBLE_EQ(standard_deviation({1e9 + 4, 1e9 + 7, 1e9 + 13, 1e9 + 16}), std::sqrt(30.0));
}

TEST(Statistics, Median) {
  EXPECT_EQ(median({3, 1, 2}), 2);
  EXPECT_EQ(median({4, 1, 3, 2}), 2.5);
  EXPECT_EQ(median({7}), 7);
}

// Seven values against numpy 2: mean, std(ddof=1) and quantile.
TEST(Statistics, AgreesWithNumpy) {
  const std::vector<double> values = {3.1, -2.0, 8.5, 0.25, 4.0, 4.0, 11.75};
  EXPECT_DOUBLE_EQ(mean(values), 4.228571428571429);
  EXPECT_DOUBLE_EQ(standard_deviation(values), 4.669391211465825);
  EXPECT_DOUBLE_EQ(quantile(values, 0.05), -1.325);
  EXPECT_DOUBLE_EQ(quantile(values, 0.25), 1.675);
  EXPECT_DOUBLE_EQ(quantile(values, 0.6), 4.0);
  EXPECT_DOUBLE_EQ(quantile(values, 0.9), 9.8);
  EXPECT_DOUBLE_EQ(quantile(values, 0.95), 10.774999999999999);
}

TEST(Statistics, InfiniteValuesDoNotSpoilAFiniteQuantile) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  EXPECT_EQ(median({1, 2, kInfinity}), 2);
  EXPECT_EQ(median({1, kInfinity}), kInfinity);
  EXPECT_EQ(quantile({1, kInfinity, kInfinity}, 0.75), kInfinity);
  EXPECT_EQ(quantile({-kInfinity, 1, 2}, 0.5), 1);
}

TEST(Statistics, QuantileInterpolates) {
  const std::vector<double> values = {15, 20, 35, 40, 50};
  EXPECT_EQ(quantile(values, 0), 15);
  EXPECT_EQ(quantile(values, 1), 50);
  EXPECT_DOUBLE_EQ(quantile(values, 0.4), 29);  // 20 + 0.6 (35 - 20)
  EXPECT_DOUBLE_EQ(quantile(values, 0.95), 48);
}

// Newcombe, Statistics in Medicine 17 (1998), table I, method 3.
TEST(Statistics, WilsonIntervalOfNewcombe) {
  const struct {
    std::size_t successes, trials;
    double low, high;
  } rows[] = {{81, 263, 0.2553, 0.3662},
              {15, 148, 0.0624, 0.1605},
              {0, 20, 0, 0.1611},
              {1, 29, 0.0061, 0.1718}};
  for (const auto& row : rows) {
    const Interval interval = wilson_interval(row.successes, row.trials);
    EXPECT_NEAR(interval.low, row.low, 5.1e-5);
    EXPECT_NEAR(interval.high, row.high, 5.1e-5);
  }
}

TEST(Statistics, WilsonIntervalIsSymmetricAndHoldsTheRate) {
  for (std::size_t trials = 1; trials <= 40; ++trials) {
    for (std::size_t successes = 0; successes <= trials; ++successes) {
      const Interval interval = wilson_interval(successes, trials);
      const Interval mirror = wilson_interval(trials - successes, trials);
      const double rate = static_cast<double>(successes) / static_cast<double>(trials);
      EXPECT_NEAR(interval.low, 1 - mirror.high, 1e-15);
      EXPECT_LE(interval.low, rate);
      EXPECT_GE(interval.high, rate);
      EXPECT_GE(interval.low, 0);
      EXPECT_LE(interval.high, 1);
    }
  }
  EXPECT_EQ(wilson_interval(0, 10).low, 0);
  EXPECT_EQ(wilson_interval(10, 10).high, 1);
}

TEST(Statistics, UnusableInputIsRefused) {
  EXPECT_THROW(mean({}), BadInput);
  EXPECT_THROW(median({}), BadInput);
  EXPECT_THROW(quantile({}, 0.5), BadInput);
  EXPECT_THROW(standard_deviation({1}), BadInput);
  EXPECT_THROW(quantile({1, 2}, 1.5), BadInput);
  EXPECT_THROW(quantile({1, 2}, std::numeric_limits<double>::quiet_NaN()), BadInput);
  EXPECT_THROW(median({1, std::numeric_limits<double>::quiet_NaN(), 2}), BadInput);
  EXPECT_THROW(wilson_interval(0, 0), BadInput);
  EXPECT_EQ(error_message([] { wilson_interval(3, 2); }), "a rate of 3 successes in 2 trials");
}

}  // namespace
}  // namespace palpate
