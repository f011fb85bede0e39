// SPDX-License-Identifier: Apache-2.0
#include "registration/false_alarms.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "palpate/registration/registration.hpp"
#include "registration/problems.hpp"

namespace palpate::registration {
namespace {

const BackgroundModel kModel{
    .pairs = 1000, .inertia = 50 * Eigen::Matrix3d::Identity(), .radius = 1, .rate = 0.5};

TEST(FalseAlarms, GrowsWithPairsRateAndResiduals) {
  const double expected = number_of_false_alarms(kModel, 1.5, 8);
  EXPECT_GT(expected, 0);
  BackgroundModel more = kModel;
  more.pairs *= 2;
  EXPECT_NEAR(number_of_false_alarms(more, 1.5, 8), 2 * expected, 1e-9 * expected);
  more = kModel;
  more.rate *= 2;
  EXPECT_NEAR(number_of_false_alarms(more, 1.5, 8), std::pow(2, 7) * expected, 1e-6 * expected);
  // A ball in 3 * 8 - 6 dimensions.
  EXPECT_NEAR(number_of_false_alarms(kModel, 3.0, 8), std::pow(2, 9) * expected, 1e-6 * expected);
  EXPECT_LT(number_of_false_alarms(kModel, 2.0, 12), expected);
}

TEST(FalseAlarms, TheRadiusOfTheRateDoesNotMatterWhereItIsUniform) {
  BackgroundModel narrow = kModel;
  narrow.radius = 0.5;
  narrow.rate /= 8;  // a ball of an eighth of the volume gets an eighth
  const double expected = number_of_false_alarms(kModel, 1.5, 8);
  EXPECT_NEAR(number_of_false_alarms(narrow, 1.5, 8), expected, 1e-6 * expected);
}

TEST(FalseAlarms, FewAreAlwaysExpected) {
  EXPECT_TRUE(std::isinf(number_of_false_alarms(kModel, 0, 3)));
  EXPECT_TRUE(std::isinf(number_of_false_alarms(kModel, 0, 2)));
  BackgroundModel crowded = kModel;
  crowded.rate = 1e4;
  EXPECT_TRUE(std::isfinite(number_of_false_alarms(crowded, 1e5, 100000)));
  EXPECT_LT(number_of_false_alarms(kModel, 190, 1000), 1e-300);
}

// Not below the binomial tail, and below one half from a surplus of some pairs on.
TEST(SignTest, BoundsTheBinomialTail) {
  for (int all = 1; all <= 40; ++all) {
    double tail = 0, term = std::pow(0.5, all);  // of all, all - 1, ..
    for (int more = all; more >= 0; --more) {
      tail += term;
      EXPECT_GE(sign_test(more, all - more), tail * (1 - 1e-9)) << more << " of " << all;
      term *= static_cast<double>(more) / (all - more + 1);
    }
  }
  EXPECT_EQ(sign_test(20, 20), 1);
  EXPECT_LT(sign_test(30, 10), 0.01);
  EXPECT_NEAR(sign_test(10, 0), std::pow(0.5, 10), 1e-12);
}

// Single precision leaves a line's least inertia to rounding, below zero too, and overflows: the
// number is then too large rather than none.
TEST(FalseAlarms, IsANumberWhereTheInertiaIsNot) {
  BackgroundModel line = kModel;
  line.inertia = Eigen::Vector3d(1e16, 1e16, 100).asDiagonal();
  const double expected = number_of_false_alarms(line, 1.5, 8);
  line.inertia(2, 2) = -1e9;
  EXPECT_GE(number_of_false_alarms(line, 1.5, 8), expected);
  line.inertia(0, 0) = std::numeric_limits<double>::infinity();
  EXPECT_TRUE(std::isinf(number_of_false_alarms(line, 1.5, 8)));
}

TEST(MatchingRadius, IsThatOfABallOfTheSameMeanSquare) {
  RandomStream random(1, "ball");
  constexpr int kCount = 20000;
  double squares = 0;
  for (int i = 0; i < kCount; ++i) {
    squares += std::pow(0.7 * std::cbrt(random.uniform()), 2);
  }
  EXPECT_NEAR(matching_radius(3, squares, kCount), 0.7, 0.01);
  EXPECT_EQ(matching_radius(3, 100, 4), 1);
  EXPECT_GT(matching_radius(3, 0, 4), 0);
}

// What the number says must come true: of problems without inliers at most one in a hundred may
// have a pose that is expected less than 0.01 times. That many should have one expected less than
// once is no more than that it does not refuse everything.
TEST(FalseAlarms, IsCalibrated) {
  int below_one = 0, below_hundredth = 0;
  constexpr int kRuns = 200;
  for (std::uint64_t seed = 0; seed < kRuns; ++seed) {
    const auto problem = testing::make_problem({.pairs = 300, .outliers = 1, .noise = 0.001},
                                               RandomStream(seed, "calibration"));
    const auto result = register_correspondences(problem.correspondences);
    below_one += result.false_alarms < 1;
    below_hundredth += result.false_alarms < 0.01;
  }
  EXPECT_GT(below_one, kRuns / 20);
  EXPECT_LT(below_one, kRuns * 63 / 100);  // 1 - 1/e
  EXPECT_LE(below_hundredth, 5);           // 2 expected; more than 5 once in 60 times
}

/// Points of a grid of so many steps an axis.
std::vector<Eigen::Vector3d> grid_points(int count, int steps, double width, RandomStream& random) {
  std::vector<Eigen::Vector3d> points;
  for (int i = 0; i < count; ++i) {
    Eigen::Vector3d p;
    for (double& x : p)
      x = width * static_cast<double>(random.index(static_cast<std::size_t>(steps)));
    points.push_back(p);
  }
  return points;
}

// Wrong pairs agree exactly or not at all there: four exact ones are no evidence.
TEST(FalseAlarms, CoordinatesOnAGridAreNoConsensus) {
  int found = 0;
  for (std::uint64_t seed = 0; seed < 100; ++seed) {
    RandomStream random(seed, "grid");
    const Correspondences integers{
        grid_points(300, 10, 1, random), grid_points(300, 10, 1, random), {}, {}};
    const Correspondences centimetres{
        grid_points(150, 11, 0.01, random), grid_points(150, 11, 0.01, random), {}, {}};
    found += register_correspondences(integers, {.noise_bound = 0.5}).T_target_source.has_value();
    found += register_correspondences(centimetres).T_target_source.has_value();
  }
  EXPECT_LE(found, 2);
}

// Each point of a cube of points with another one, the cube turned.
TEST(FalseAlarms, AShuffledLatticeIsNoConsensus) {
  int found = 0;
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    RandomStream random(seed, "lattice");
    const Eigen::Isometry3d T = testing::random_pose(random);
    Correspondences c;
    for (int i = 0; i < 125; ++i)
      c.source.emplace_back(0.01 * (i % 5), 0.01 * (i / 5 % 5), 0.01 * (i / 25));
    for (const auto& p : c.source) c.target.push_back(T * p);
    for (std::size_t i = 124; i > 0; --i) std::swap(c.target[i], c.target[random.index(i + 1)]);
    for (const double bound : {0.004, 0.0005}) {
      found += register_correspondences(c, {.noise_bound = bound}).T_target_source.has_value();
    }
  }
  EXPECT_LE(found, 1);
}

TEST(FalseAlarms, RightPairsOnAGridAreFound) {
  const Eigen::Isometry3d turns[] = {
      Eigen::Isometry3d(Eigen::AngleAxisd(std::numbers::pi / 2, Eigen::Vector3d::UnitZ())),
      Eigen::Isometry3d(Eigen::AngleAxisd(0.05, Eigen::Vector3d::UnitZ()))};
  for (const double step : {0.001, 0.01}) {
    for (const Eigen::Isometry3d& T : turns) {
      RandomStream random(7, "right pairs on a grid");
      const int steps = static_cast<int>(std::lround(0.1 / step));
      Correspondences c{grid_points(300, steps, step, random), {}, {}, {}};
      for (const auto& p : c.source) c.target.push_back((T * p / 0.001).array().round() * 0.001);
      std::rotate(c.target.begin(), c.target.begin() + 7, c.target.begin() + 120);
      const auto result = register_correspondences(c);
      ASSERT_TRUE(result.T_target_source) << step;
      EXPECT_LT(testing::rotation_error_deg(*result.T_target_source, T), 0.5) << step;
    }
  }
}

// Random pairs of the corners of a box agree all eight in 4 of 40320 cases.
TEST(FalseAlarms, AllOfFewPairsOnAGridAreFound) {
  Correspondences box, square;
  for (int i = 0; i < 8; ++i)
    box.source.emplace_back(0.1 * (i % 2), 0.07 * (i / 2 % 2), 0.03 * (i / 4));
  for (int i = 0; i < 9; ++i) square.source.emplace_back(0.05 * (i % 3), 0.05 * (i / 3), 0);
  for (Correspondences* c : {&box, &square}) {
    RandomStream random(5, "corners");
    const Eigen::Isometry3d T = testing::random_pose(random);
    for (const auto& p : c->source) c->target.push_back(T * p);
    const auto result = register_correspondences(*c);
    ASSERT_TRUE(result.T_target_source) << c->source.size();
    EXPECT_EQ(result.inliers.size(), c->source.size());
  }
}

}  // namespace
}  // namespace palpate::registration
