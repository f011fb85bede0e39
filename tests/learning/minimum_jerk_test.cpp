// SPDX-License-Identifier: Apache-2.0
#include "palpate/learning/demonstrations/minimum_jerk.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "palpate/core/error.hpp"
#include "palpate/core/random.hpp"

namespace palpate::learning {
namespace {

Eigen::VectorXd times(int count, double step) {
  return Eigen::VectorXd::LinSpaced(count, 0, (count - 1) * step);
}

TEST(MinimumJerk, LeavesAParabolaAsItIs) {
  const auto t = times(20, 1.0 / 30);
  const Eigen::MatrixXd points = (0.3 + t.array() - 2 * t.array().square()).matrix().transpose();
  const auto motion = minimum_jerk(t, points, 0.2, 0.01);
  for (Eigen::Index i = 2; i + 2 < motion.position.cols(); ++i) {
    const double now = 0.01 * static_cast<double>(i);
    // Between two samples the points are read on a straight line: an error of a / 8 step^2.
    EXPECT_NEAR(motion.position(0, i), 0.3 + now - 2 * now * now, 1e-4);
    EXPECT_NEAR(motion.velocity(0, i), 1 - 4 * now, 5e-3);
    EXPECT_NEAR(motion.acceleration(0, i), -4, 0.05);
  }
}

TEST(MinimumJerk, GoesThroughThePointsWithoutSmoothing) {
  RandomStream random(3);
  const auto t = times(12, 0.05);
  Eigen::MatrixXd points(2, 12);
  for (double& value : points.reshaped()) value = random.normal();
  const auto motion = minimum_jerk(t, points, 0, 0.01);
  ASSERT_EQ(motion.position.cols(), 56);
  for (Eigen::Index i = 0; i < 12; ++i) {
    EXPECT_LT((motion.position.col(5 * i) - points.col(i)).norm(), 1e-4);
  }
}

TEST(MinimumJerk, SmoothingTakesNoiseAway) {
  RandomStream random(4);
  const auto t = times(100, 0.01);
  Eigen::MatrixXd truth(1, 100), noisy(1, 100);
  for (Eigen::Index i = 0; i < 100; ++i) {
    truth(0, i) = minimum_jerk_share(t[i]);
    noisy(0, i) = truth(0, i) + 0.01 * random.normal();
  }
  const auto motion = minimum_jerk(t, noisy, 0.05, 0.01);
  EXPECT_LT((motion.position - truth).norm(), 0.5 * (noisy - truth).norm());
}

TEST(MinimumJerk, ShareRunsFromRestToRest) {
  EXPECT_EQ(minimum_jerk_share(-1), 0);
  EXPECT_EQ(minimum_jerk_share(0.5), 0.5);
  EXPECT_EQ(minimum_jerk_share(2), 1);
  EXPECT_NEAR(minimum_jerk_share(1e-3) / 1e-3, 0, 1e-4);
}

TEST(MinimumJerk, RejectsBadInput) {
  const Eigen::MatrixXd points = Eigen::MatrixXd::Zero(1, 3);
  EXPECT_THROW(minimum_jerk(Eigen::Vector3d(0, 1, 1), points, 0, 0.01), BadInput);
  EXPECT_THROW(minimum_jerk(Eigen::Vector2d(0, 1), points, 0, 0.01), BadInput);
  EXPECT_THROW(minimum_jerk(Eigen::Vector3d(0, 1, 2), points, 0, 0), BadInput);
  EXPECT_THROW(minimum_jerk(Eigen::Vector3d(0, 1, NAN), points, 0, 0.01), BadInput);
  EXPECT_THROW(minimum_jerk({}, Eigen::MatrixXd(1, 0), 0, 0.01), BadInput);
}

}  // namespace
}  // namespace palpate::learning
