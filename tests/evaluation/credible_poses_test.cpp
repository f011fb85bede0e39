// SPDX-License-Identifier: Apache-2.0
#include "palpate/evaluation/credible_poses.hpp"

#include <gtest/gtest.h>

#include <numbers>

#include "localization/mode_at.hpp"

namespace palpate::evaluation {
namespace {

using localization::mode_at;

TEST(CrediblePosesTest, AreSortedAndKeepTheirShares) {
  localization::Posterior posterior;
  posterior.modes = {mode_at({1, 0, 0}, 0.2), mode_at({2, 0, 0}, 0.6), mode_at({3, 0, 0}, 0.001)};
  posterior.residual_set = {mode_at({4, 0, 0}, 0).T_frame_object,
                            mode_at({5, 0, 0}, 0).T_frame_object};
  const auto poses = credible_poses(posterior, 10);
  ASSERT_EQ(poses.size(), 4u);
  EXPECT_EQ(poses[0].T_frame_object.translation().x(), 2);
  EXPECT_EQ(poses[0].probability, 0.6);
  EXPECT_EQ(poses[1].probability, 0.2);
  EXPECT_NEAR(poses[2].probability, posterior.residual_mass() / 2, 1e-12);
  EXPECT_EQ(credible_poses(posterior, 1).size(), 1u);
}

TEST(CrediblePosesTest, AreDrawnWhereAllAreImprobable) {
  localization::Posterior posterior;
  for (int i = 0; i < 100; ++i) posterior.modes.push_back(mode_at({1.0 * i, 0, 0}, 0.002));
  posterior.modes.push_back(mode_at({100, 0, 0}, 0.0001));
  EXPECT_EQ(credible_poses(posterior, 120).size(), 100u);
}

TEST(CrediblePosesTest, GoAlongAFreeAxis) {
  localization::Posterior posterior;
  posterior.modes = {mode_at({0.1, 0, 0}, 0.9)};
  posterior.modes[0].free_axis = {Eigen::Vector3d::Zero(), Eigen::Vector3d::UnitZ(),
                                  std::numbers::pi / 2};
  const auto poses = credible_poses(posterior, 100);
  ASSERT_GT(poses.size(), 2u);
  double total = 0;
  for (const auto& pose : poses) {
    total += pose.probability;
    EXPECT_NEAR(pose.T_frame_object.translation().norm(), 0.1, 1e-12);
    EXPECT_GE(pose.T_frame_object.translation().x(), -1e-12);
  }
  EXPECT_NEAR(total, 0.9, 1e-12);
  EXPECT_NEAR(poses.front().T_frame_object.translation().y(), -0.1, 1e-12);
  EXPECT_NEAR(poses.back().T_frame_object.translation().y(), 0.1, 1e-12);
}

TEST(PriorPosesTest, StandForTheirOwnBallAlone) {
  estimation::EstimationOptions options;
  options.resting_half_width = 0.02;
  const double places = 0.04 * 0.04 / (std::numbers::pi * 0.01 * 0.01);
  geometry::KnownObject object;
  object.symmetries = {Eigen::Matrix3d::Identity()};
  object.stable_poses = {{Eigen::Matrix3d::Identity(), 0.03, 1}};
  const auto poses = prior_poses(object, options);
  ASSERT_GT(poses.size(), 10u);
  for (const auto& pose : poses) EXPECT_NEAR(pose.probability, 1 / (36 * places), 1e-12);

  // A turn about the vertical that keeps the shape halves them; one that turns it over does not.
  const Eigen::Matrix3d half(Eigen::AngleAxisd(std::numbers::pi, Eigen::Vector3d::UnitZ()));
  const Eigen::Matrix3d over(Eigen::AngleAxisd(std::numbers::pi, Eigen::Vector3d::UnitX()));
  object.symmetries.push_back(half);
  EXPECT_NEAR(prior_poses(object, options)[0].probability, 1 / (18 * places), 1e-12);
  object.symmetries = {Eigen::Matrix3d::Identity(), over};
  EXPECT_NEAR(prior_poses(object, options)[0].probability, 1 / (36 * places), 1e-12);
}

}  // namespace
}  // namespace palpate::evaluation
