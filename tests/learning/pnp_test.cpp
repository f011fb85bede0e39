// SPDX-License-Identifier: Apache-2.0
#include "learning/demonstrations/pnp.hpp"

#include <gtest/gtest.h>

#include "palpate/core/error.hpp"
#include "palpate/core/random.hpp"
#include "palpate/core/se3.hpp"

namespace palpate::learning {
namespace {

struct Matches {
  Eigen::Isometry3d T;
  Eigen::Matrix3Xd points;
  Eigen::Matrix2Xd pixels;
};

/// Points of a thing of 10 cm, half a metre away. @param wrong  share of matches anywhere
Matches make_matches(int count, double noise, double wrong, RandomStream& random) {
  const PinholeCamera camera;
  Matches m{Eigen::Isometry3d(random.rotation()), Eigen::Matrix3Xd(3, count),
            Eigen::Matrix2Xd(2, count)};
  m.T.translation() = Eigen::Vector3d(0.05, -0.03, 0.5) + 0.02 * random.normal3();
  for (int i = 0; i < count; ++i) {
    m.points.col(i) = 0.05 * random.unit_vector();
    m.pixels.col(i) = camera.project(m.T * m.points.col(i)) +
                      noise * Eigen::Vector2d(random.normal(), random.normal());
    if (i < wrong * count) m.pixels.col(i) << random.uniform(0, 640), random.uniform(0, 480);
  }
  return m;
}

TEST(Pnp, ExactMatchesGiveTheExactPose) {
  RandomStream random(1);
  for (int trial = 0; trial < 20; ++trial) {
    const auto m = make_matches(12, 0, 0, random);
    const auto result = solve_pnp({}, m.points, m.pixels);
    ASSERT_EQ(result.status, PnpStatus::ok);
    EXPECT_LT((result.T_camera_object.matrix() - m.T.matrix()).norm(), 1e-6);
  }
}

TEST(Pnp, StandsNoiseAndWrongMatches) {
  RandomStream random(2);
  for (int trial = 0; trial < 20; ++trial) {
    const auto m = make_matches(60, 0.5, 0.3, random);
    const auto result = solve_pnp({}, m.points, m.pixels, {}, 7);
    ASSERT_EQ(result.status, PnpStatus::ok);
    // Half a pixel at 0.5 m and focal 600 is 0.4 mm; over forty points much less, but for depth.
    EXPECT_LT((result.T_camera_object.translation() - m.T.translation()).norm(), 0.005);
    EXPECT_LT(rotation_distance(result.T_camera_object.linear(), m.T.linear()), 0.02);
    EXPECT_GE(result.inliers.size(), 40U);
    EXPECT_LT(result.rms, 1);
  }
}

TEST(Pnp, SaysWhenThereIsNoPose) {
  RandomStream random(3);
  const auto few = make_matches(5, 0, 0, random);
  EXPECT_EQ(solve_pnp({}, few.points, few.pixels).status, PnpStatus::too_few_matches);
  const auto wrong = make_matches(20, 0, 1, random);
  EXPECT_EQ(solve_pnp({}, wrong.points, wrong.pixels).status, PnpStatus::no_consensus);
  Eigen::Matrix3Xd point = Eigen::Matrix3Xd::Zero(3, 20);
  EXPECT_EQ(solve_pnp({}, point, wrong.pixels).status, PnpStatus::no_consensus);
}

TEST(Pnp, RejectsBadInput) {
  RandomStream random(4);
  auto m = make_matches(10, 0, 0, random);
  EXPECT_THROW(solve_pnp({}, m.points, m.pixels.leftCols(9)), BadInput);
  m.pixels(0, 3) = std::numeric_limits<double>::infinity();
  EXPECT_THROW(solve_pnp({}, m.points, m.pixels), BadInput);
}

}  // namespace
}  // namespace palpate::learning
