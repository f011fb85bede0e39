// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>

#include "palpate/core/random.hpp"
#include "palpate/hand/shadow.hpp"
#include "palpate/planning/trajectory.hpp"

namespace palpate::planning {
namespace {

constexpr double kTolerance = 1 + 1e-6;  // of rounding
const Coordinates kMetric = metric(hand::shadow_hand());

std::vector<Coordinates> random_corners(RandomStream& random, int count) {
  std::vector<Coordinates> corners;
  for (int i = 0; i < count; ++i) {
    Coordinates corner(kMetric.size());
    for (double& value : corner) value = random.uniform(-0.3, 0.3);
    corners.push_back(corner);
  }
  return corners;
}

/// Finite differences of samples are means of speed and acceleration, so the limits bound them.
void expect_within_limits(const std::vector<Coordinates>& samples, const MotionLimits& limits) {
  const Coordinates speed = speed_limits(limits, kMetric.size()),
                    acceleration = acceleration_limits(limits, kMetric.size());
  const double dt = hand::kTick;
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const Coordinates& before = samples[i == 0 ? 0 : i - 1];
    const Coordinates& after = samples[std::min(i + 1, samples.size() - 1)];
    const Coordinates v = (after - samples[i]) / dt;
    const Coordinates a = (after - 2 * samples[i] + before) / (dt * dt);
    ASSERT_LE(v.cwiseAbs().cwiseQuotient(speed).maxCoeff(), kTolerance) << i;
    ASSERT_LE(a.cwiseAbs().cwiseQuotient(acceleration).maxCoeff(), kTolerance) << i;
  }
}

TEST(Rounded, KeepsTheEndsAndTheDirectionContinuous) {
  RandomStream random(1);
  for (int trial = 0; trial < 50; ++trial) {
    const auto corners = random_corners(random, 2 + trial % 5);
    const auto path = rounded(corners, std::vector<double>(corners.size(), 0.05), kMetric);
    EXPECT_LT((path.front().at(0) - corners.front()).norm(), 1e-12);
    EXPECT_LT((path.back().at(path.back().length) - corners.back()).norm(), 1e-9);
    for (std::size_t i = 1; i < path.size(); ++i) {
      const PathPiece& before = path[i - 1];
      EXPECT_LT((before.at(before.length) - path[i].at(0)).norm(), 1e-9);
      EXPECT_LT((before.tangent(before.length) - path[i].tangent(0)).norm(), 1e-9);
    }
  }
}

TEST(Rounded, StaysWithinTheCutOfTheCorners) {
  RandomStream random(2);
  const auto corners = random_corners(random, 3);
  const auto path = rounded(corners, {0, 0.05, 0}, kMetric);
  ASSERT_EQ(path.size(), 3U);
  for (double u : {0.0, 0.02, 0.05, 0.08, 0.1}) {
    EXPECT_LE(distance(path[1].at(u), corners[1], kMetric), 0.05 + 1e-9);
  }
}

TEST(TimePath, StaysWithinEveryLimit) {
  RandomStream random(3);
  for (int trial = 0; trial < 40; ++trial) {
    const auto corners = random_corners(random, 2 + trial % 5);
    const std::vector<double> cuts(corners.size(), trial % 3 == 0 ? 0.0 : 0.04);
    MotionLimits limits;
    limits.joint_speed = random.uniform(0.2, 4);
    limits.joint_acceleration = random.uniform(1, 20);
    limits.mount_speed = random.uniform(0.05, 1);
    const auto samples = time_path(rounded(corners, cuts, kMetric), limits, kMetric);
    EXPECT_LT((samples.front() - corners.front()).norm(), 1e-12);
    EXPECT_LT((samples.back() - corners.back()).norm(), 1e-9);
    expect_within_limits(samples, limits);
  }
}

/// Bang-coast-bang: d / v + v / a, and 2 sqrt(d / a) where the speed limit is not reached.
TEST(TimePath, TakesTheLeastTimeAlongALine) {
  MotionLimits limits;
  const Coordinates start = Coordinates::Zero(kMetric.size());
  Coordinates far = start, near = start;
  far[0] = 0.5, near[0] = 0.01;
  const auto seconds = [&](const Coordinates& end) {
    const auto samples = time_path(rounded({start, end}, {0, 0}, kMetric), limits, kMetric);
    return static_cast<double>(samples.size() - 1) * hand::kTick;
  };
  EXPECT_NEAR(seconds(far), 0.5 / 0.25 + 0.25 / 1.0, 0.03);
  EXPECT_NEAR(seconds(near), 2 * std::sqrt(0.01 / 1.0), 0.03);
}

TEST(TimePath, RoundedCornersAreFasterThanStops) {
  RandomStream random(4);
  const auto corners = random_corners(random, 5);
  const auto stopping =
      time_path(rounded(corners, std::vector<double>(5, 0.0), kMetric), MotionLimits{}, kMetric);
  const auto flowing =
      time_path(rounded(corners, std::vector<double>(5, 0.05), kMetric), MotionLimits{}, kMetric);
  EXPECT_LT(flowing.size(), stopping.size());
}

}  // namespace
}  // namespace palpate::planning
