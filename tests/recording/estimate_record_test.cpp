// SPDX-License-Identifier: Apache-2.0
#include "palpate/recording/estimate_record.hpp"

#include <gtest/gtest.h>

#include "palpate/core/error.hpp"

namespace palpate::recording {
namespace {

using localization::PoseStatus;

estimation::HeldPoseEstimate two_modes() {
  estimation::HeldPoseEstimate estimate;
  estimate.posterior.status = PoseStatus::ambiguous;
  for (const double weight : {0.6, 0.3}) {
    localization::Mode mode;
    mode.T_frame_object.translation().x() = weight;
    mode.T_frame_object.linear() = exp_so3(Eigen::Vector3d(0, weight, 0.1));
    mode.weight = weight;
    mode.covariance.diagonal().setConstant(weight / 7);
    estimate.posterior.modes.push_back(mode);
  }
  estimate.posterior.modes.back().free_axis = {Eigen::Vector3d(0.1, 0.2, 0.3),
                                               Eigen::Vector3d::UnitY(), 0.4, 0.25};
  estimate.contacts.resize(3);
  return estimate;
}

TEST(EstimateRecord, HasTheModesToTheLastBit) {
  const auto estimate = two_modes();
  const EstimateRecord record = estimate_record(1.5, estimate);
  EXPECT_EQ(record.time, 1.5);
  EXPECT_EQ(record.status, "ambiguous");
  EXPECT_EQ(record.contacts.size(), 3u);
  const localization::Posterior again = posterior_of(record);
  EXPECT_EQ(again.status, PoseStatus::ambiguous);
  ASSERT_EQ(again.modes.size(), 2u);
  for (std::size_t i = 0; i < 2; ++i) {
    const auto &mode = again.modes[i], &given = estimate.posterior.modes[i];
    EXPECT_EQ(mode.T_frame_object.matrix(), given.T_frame_object.matrix());
    EXPECT_EQ(mode.weight, given.weight);
    EXPECT_EQ(mode.covariance, given.covariance);
  }
  EXPECT_FALSE(again.modes[0].free_axis);
  ASSERT_TRUE(again.modes[1].free_axis);
  EXPECT_EQ(again.modes[1].free_axis->point, Eigen::Vector3d(0.1, 0.2, 0.3));
  EXPECT_EQ(again.modes[1].free_axis->direction, Eigen::Vector3d(0, 1, 0));
  EXPECT_EQ(again.modes[1].free_axis->extent, 0.4);
  EXPECT_EQ(again.modes[1].free_axis->share, 0.25);
}

TEST(EstimateRecord, EveryStatusIsReadAndNoOther) {
  for (const auto status : {PoseStatus::certain, PoseStatus::ambiguous, PoseStatus::no_pose}) {
    estimation::HeldPoseEstimate estimate;
    estimate.posterior.status = status;
    EXPECT_EQ(posterior_of(estimate_record(0, estimate)).status, status);
  }
  EstimateRecord other;
  other.status = "sure";
  EXPECT_THROW((void)posterior_of(other), BadInput);
}

}  // namespace
}  // namespace palpate::recording
