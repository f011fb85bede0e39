// SPDX-License-Identifier: Apache-2.0
#include "palpate/registration/chance.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "palpate/registration/registration.hpp"
#include "problems.hpp"

namespace palpate::registration {
namespace {

TEST(Chance, GrowsWithRateTriplesAndResiduals) {
  const ChanceModel model{.triples = 1000, .rate = 0.5, .dimensions = 3};
  const double expected = expected_by_chance(model, 1.5, 8);
  EXPECT_GT(expected, 0);
  EXPECT_NEAR(expected_by_chance({2000, 0.5, 3}, 1.5, 8), 2 * expected, 1e-9 * expected);
  EXPECT_NEAR(expected_by_chance({1000, 1.0, 3}, 1.5, 8), std::pow(2, 5) * expected,
              1e-9 * expected);
  // A ball in 3 * 8 - 6 dimensions.
  EXPECT_NEAR(expected_by_chance(model, 3.0, 8), std::pow(2, 9) * expected, 1e-6 * expected);
  EXPECT_LT(expected_by_chance(model, 2.0, 12), expected);
}

TEST(Chance, FewAreAlwaysExpected) {
  const ChanceModel model{.triples = 1000, .rate = 0.5, .dimensions = 3};
  EXPECT_EQ(expected_by_chance(model, 0, 3), 1000);
  EXPECT_TRUE(std::isinf(expected_by_chance(model, 0, 2)));
  EXPECT_TRUE(std::isfinite(expected_by_chance({1e9, 1e4, 5}, 1e5, 100000)));
  EXPECT_LT(expected_by_chance(model, 190, 1000), 1e-300);
}

// What the number says must come true: of problems without inliers, about one in e^-1 has a pose
// that is expected less than once, one in a hundred one that is expected less than 0.01 times.
TEST(Chance, IsCalibrated) {
  int below_one = 0, below_hundredth = 0;
  constexpr int kRuns = 80;
  for (std::uint64_t seed = 0; seed < kRuns; ++seed) {
    const auto problem = testing::make_problem({.pairs = 300, .outliers = 1, .noise = 0.001},
                                               RandomStream(seed, "calibration"));
    const auto result = register_correspondences(problem.correspondences, {.false_alarm = 1e9});
    below_one += result.expected_by_chance < 1;
    below_hundredth += result.expected_by_chance < 0.01;
  }
  EXPECT_GT(below_one, kRuns / 10);  // else it would refuse too much: 1 - 1/e of them at best
  EXPECT_LT(below_one, kRuns * 9 / 10);
  EXPECT_LE(below_hundredth, 5);  // 0.8 expected; more than 5 once in 4000 times
}

}  // namespace
}  // namespace palpate::registration
