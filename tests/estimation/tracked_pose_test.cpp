// SPDX-License-Identifier: Apache-2.0
#include "estimation/tracked_pose.hpp"

#include <gtest/gtest.h>

#include <numbers>

namespace palpate::estimation {
namespace {

using localization::PoseStatus;
using localization::Posterior;

const std::vector<Eigen::Matrix3d> kNone = {Eigen::Matrix3d::Identity()};

Eigen::Isometry3d turned(double angle) {
  return Eigen::Isometry3d(Eigen::AngleAxisd(angle, Eigen::Vector3d::UnitZ()));
}

localization::Mode mode(double angle, double weight) { return {turned(angle), weight, {}, {}}; }

Posterior one_pose(double angle, double weight) {
  Posterior posterior;
  posterior.status = PoseStatus::certain;
  posterior.modes = {mode(angle, weight)};
  return posterior;
}

TEST(TrackedPose, ThatAgreesChangesNothing) {
  Posterior posterior = one_pose(0.05, 0.98);
  add_tracked_pose(mode(0, 1), kNone, posterior);
  EXPECT_EQ(posterior.status, PoseStatus::certain);
  ASSERT_EQ(posterior.modes.size(), 1u);
  EXPECT_EQ(posterior.modes[0].weight, 0.98);
}

TEST(TrackedPose, ThatContradictsMayBeIt) {
  Posterior posterior = one_pose(0.2, 0.95);
  add_tracked_pose(mode(0, 0.9), kNone, posterior);
  EXPECT_EQ(posterior.status, PoseStatus::ambiguous);
  ASSERT_EQ(posterior.modes.size(), 2u);
  EXPECT_NEAR(posterior.modes[0].weight, 0.57, 1e-12);
  EXPECT_NEAR(posterior.modes[1].weight, 0.36, 1e-12);
  EXPECT_TRUE(posterior.modes[1].T_frame_object.isApprox(turned(0), 1e-12));
}

TEST(TrackedPose, MaySurpassADoubtfulOne) {
  Posterior posterior = one_pose(0.2, 0.3);
  add_tracked_pose(mode(0, 1), kNone, posterior);
  EXPECT_TRUE(posterior.modes[0].T_frame_object.isApprox(turned(0), 1e-12));
}

TEST(TrackedPose, OfASymmetricObjectAgreesInAnyOfItsCopies) {
  Posterior posterior = one_pose(std::numbers::pi, 0.98);
  const std::vector<Eigen::Matrix3d> half_turn = {Eigen::Matrix3d::Identity(),
                                                  turned(std::numbers::pi).linear()};
  add_tracked_pose(mode(0, 1), half_turn, posterior);
  EXPECT_EQ(posterior.modes.size(), 1u);
}

TEST(TrackedPose, IsNoneWhereNothingIsKnown) {
  Posterior nothing;
  add_tracked_pose(mode(0, 1), kNone, nothing);
  EXPECT_TRUE(nothing.modes.empty());
}

}  // namespace
}  // namespace palpate::estimation
