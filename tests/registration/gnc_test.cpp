// SPDX-License-Identifier: Apache-2.0
#include "palpate/registration/gnc.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "palpate/core/error.hpp"
#include "palpate/registration/registration.hpp"
#include "registration/problems.hpp"

namespace palpate::registration {
namespace {

using testing::make_problem;
using testing::rotation_error_deg;
using testing::translation_error_mm;

constexpr RobustCost kTls = RobustCost::kTruncatedLeastSquares, kGm = RobustCost::kGemanMcClure;
constexpr double kBound = 0.004;

double derivative(RobustCost cost, double z, double mu) {
  const double h = 1e-6 * (z + 1e-9);
  return (surrogate_cost(cost, z + h, mu, kBound) - surrogate_cost(cost, z - h, mu, kBound)) /
         (2 * h);
}

// phi(z) = rho(sqrt z): slope 1 at 0, slope 0 far away, concave (thesis eqs 6.9-6.12).
TEST(Surrogate, MeetsTheConditionsOfBlackAndRangarajan) {
  for (const RobustCost cost : {kTls, kGm}) {
    for (const double mu : {0.01, 0.3, 1.0, 5.0, 100.0}) {
      EXPECT_NEAR(derivative(cost, 1e-10 * mu, mu), 1, 1e-4);
      EXPECT_NEAR(derivative(cost, 1e3 * (1 + mu + 1 / mu), mu), 0, 1e-4);
      double last = 2;
      for (double z = 1e-9; z < 1; z *= 1.3) {
        const double slope = derivative(cost, z, mu);
        EXPECT_LE(slope, last + 1e-5) << "mu " << mu << " z " << z;
        last = slope;
      }
    }
  }
}

TEST(Surrogate, WeightIsTheSlopeOfTheCost) {
  for (const RobustCost cost : {kTls, kGm}) {
    for (const double mu : {0.01, 0.5, 3.0, 80.0}) {
      for (double z = 1e-8; z < 1e-2; z *= 1.7) {
        EXPECT_NEAR(surrogate_weight(cost, z, mu, kBound), derivative(cost, z, mu), 1e-4);
      }
    }
  }
}

TEST(Surrogate, ReachesTheRobustCost) {
  for (double r = 1e-4; r < 0.02; r *= 1.3) {
    const double z = r * r, c2 = kBound * kBound;
    EXPECT_NEAR(surrogate_cost(kTls, z, 1e9, kBound), std::min(z, c2), 1e-8 * c2);
    EXPECT_NEAR(surrogate_cost(kGm, z, 1, kBound), c2 * z / (c2 + z), 1e-12 * c2);
  }
}

TEST(InitialMu, IsThatOfYangNotTheInverse) {
  EXPECT_DOUBLE_EQ(*initial_mu(kTls, 0.01, 0.01), 1e-4 / (2 * 0.01 - 1e-4));
  EXPECT_DOUBLE_EQ(*initial_mu(kGm, 0.01, 0.01), 200);
  EXPECT_FALSE(initial_mu(kTls, 0.49e-4, 0.01).has_value());
}

TEST(Gnc, FindsInliersUpToEightyPercentOutliers) {
  for (const RobustCost cost : {kTls, kGm}) {
    for (const double outliers : {0.1, 0.3, 0.5, 0.7, 0.8}) {
      const auto problem = make_problem({.pairs = 500, .outliers = outliers, .noise = 0.001},
                                        RandomStream(1, "gnc"));
      const GncResult result = graduated_non_convexity(problem.correspondences, {.cost = cost});
      EXPECT_LT(rotation_error_deg(result.T_target_source, problem.truth), 1) << outliers;
    }
  }
}

// With a gap between inliers and outliers the weights are exactly the inliers.
TEST(Gnc, WeightsBecomeTheInliers) {
  const auto problem =
      make_problem({.pairs = 300, .outliers = 0.4, .noise = 0.0002}, RandomStream(2, "gnc"));
  const GncResult result = graduated_non_convexity(problem.correspondences, {.noise_bound = 0.001});
  EXPECT_EQ(result.stop, GncStop::kWeightsBinary);
  int wrong = 0;
  for (std::size_t i = 0; i < 300; ++i) {
    EXPECT_TRUE(result.weights[i] < 1e-6 || result.weights[i] > 1 - 1e-6);
    wrong += problem.inlier[i] != (result.weights[i] > 0.5);
  }
  EXPECT_LE(wrong, 2);  // a shuffled pair may fall on itself or a neighbour
}

TEST(Gnc, PlanesWorkToo) {
  const auto problem =
      make_problem({.pairs = 300, .outliers = 0.3, .noise = 0.0005}, RandomStream(3, "gnc"));
  const GncResult result = graduated_non_convexity(
      problem.correspondences, {.primitive = Primitive::kPlane, .noise_bound = 0.002});
  EXPECT_LT(rotation_error_deg(result.T_target_source, problem.truth), 1);
}

TEST(Gnc, HistoryFollowsTheSchedule) {
  const auto problem =
      make_problem({.pairs = 100, .outliers = 0.3, .noise = 0.001}, RandomStream(4, "gnc"));
  const GncResult result =
      graduated_non_convexity(problem.correspondences, {.factor = 2, .keep_history = true});
  ASSERT_EQ(result.history.size(), static_cast<std::size_t>(result.iterations));
  ASSERT_GT(result.iterations, 3);
  for (std::size_t k = 1; k < result.history.size(); ++k) {
    EXPECT_DOUBLE_EQ(result.history[k].mu, 2 * result.history[k - 1].mu);
  }
  EXPECT_EQ(result.history.back().weights, result.weights);
  EXPECT_TRUE(graduated_non_convexity(problem.correspondences).history.empty());
}

TEST(Gnc, StopsAtOnceWithoutOutliers) {
  const auto problem = make_problem({.pairs = 50, .noise = 1e-4}, RandomStream(5, "gnc"));
  const GncResult result = graduated_non_convexity(problem.correspondences);
  EXPECT_EQ(result.stop, GncStop::kAllInliers);
  EXPECT_EQ(result.weights, std::vector<double>(50, 1));
}

TEST(Gnc, BadOptions) {
  const auto problem = make_problem({.pairs = 5}, RandomStream(6, "gnc"));
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (const double bound : {0.0, -1.0, nan}) {
    EXPECT_THROW(graduated_non_convexity(problem.correspondences, {.noise_bound = bound}),
                 BadInput);
  }
  EXPECT_THROW(graduated_non_convexity(problem.correspondences, {.factor = 1}), BadInput);
  EXPECT_THROW(graduated_non_convexity(problem.correspondences, {.start_mu = 0}), BadInput);
}

// A third of the pairs agrees on another pose, with weight 0; few of large weight outweigh others.
TEST(Gnc, PairsCountByTheirWeights) {
  for (const RobustCost cost : {kTls, kGm}) {
    auto problem = make_problem({.pairs = 60, .noise = 0.0005}, RandomStream(7, "gnc"));
    auto& c = problem.correspondences;
    for (std::size_t i = 0; i < 40; ++i) c.target[i].x() += 0.05;
    c.weights.assign(60, 1);
    for (std::size_t i = 0; i < 40; ++i) c.weights[i] = 0;
    const GncResult excluded = graduated_non_convexity(c, {.cost = cost});
    EXPECT_LT(translation_error_mm(excluded.T_target_source, problem.truth), 1);
    for (std::size_t i = 0; i < 40; ++i) EXPECT_EQ(excluded.weights[i], 0);
    const auto found = register_correspondences(c, {.method = Method::kGnc, .cost = cost});
    ASSERT_TRUE(found.T_target_source);
    EXPECT_EQ(found.inliers.front(), 40);
    for (std::size_t i = 0; i < 40; ++i) c.weights[i] = 0.01;
    EXPECT_LT(translation_error_mm(graduated_non_convexity(c, {.cost = cost}).T_target_source,
                                   problem.truth),
              1);
  }
}

}  // namespace
}  // namespace palpate::registration
