// SPDX-License-Identifier: Apache-2.0
#include "skills/grasp/possible_poses.hpp"

#include <gtest/gtest.h>

#include <utility>

#include "localization/mode_at.hpp"

namespace palpate::skills {
namespace {

using localization::mode_at;

localization::Posterior posterior_of(std::vector<localization::Mode> modes) {
  localization::Posterior posterior;
  posterior.modes = std::move(modes);
  return posterior;
}

TEST(PossiblePoses, ANearlyCertainPoseIsPlannedForAlone) {
  const auto poses =
      possible_poses(posterior_of({mode_at({0.1, 0, 0}, 0.95), mode_at({0.2, 0, 0}, 0.05)}));
  ASSERT_EQ(poses.size(), 1u);
  EXPECT_EQ(poses[0].T_world_object.translation().x(), 0.1);
}

TEST(PossiblePoses, OfSeveralTheBestIsFirstWithTheOthersByWeight) {
  const auto poses = possible_poses(posterior_of(
      {mode_at({0.1, 0, 0}, 0.5), mode_at({0.2, 0, 0}, 0.1), mode_at({0.3, 0, 0}, 0.4)}));
  ASSERT_EQ(poses.size(), 3u);
  EXPECT_EQ(poses[0].T_world_object.translation().x(), 0.1);
  EXPECT_EQ(poses[1].T_world_object.translation().x(), 0.3);
  EXPECT_EQ(poses[2].T_world_object.translation().x(), 0.2);
  EXPECT_EQ(poses[1].weight, 0.4);
}

TEST(PossiblePoses, WithoutWeightAreNotPlannedFor) {
  const auto one =
      possible_poses(posterior_of({mode_at({0.1, 0, 0}, 0.6), mode_at({0.2, 0, 0}, 0)}));
  ASSERT_EQ(one.size(), 1u);
  const auto none =
      possible_poses(posterior_of({mode_at({0.1, 0, 0}, 0), mode_at({0.2, 0, 0}, 0)}));
  ASSERT_EQ(none.size(), 1u);
  EXPECT_EQ(none[0].T_world_object.translation().x(), 0.1);
  EXPECT_GT(none[0].weight, 0);
}

TEST(PossiblePoses, ThatTurnAboutAnAxisAreTheBestPoseAndTwelveInAllAtMost) {
  localization::Posterior posterior;
  for (int i = 0; i < 3; ++i) {
    auto mode = mode_at({0.1 * i, 0, 0}, i == 0 ? 0.6 : 0.2);
    mode.free_axis = {mode.T_frame_object.translation(), Eigen::Vector3d::UnitZ(), 3};
    posterior.modes.push_back(mode);
  }
  const auto poses = possible_poses(posterior);
  EXPECT_EQ(poses.size(), 12u);
  EXPECT_TRUE(poses[0].T_world_object.isApprox(posterior.modes[0].T_frame_object));
  for (std::size_t i = 1; i < poses.size(); ++i) EXPECT_LE(poses[i].weight, poses[0].weight);
}

}  // namespace
}  // namespace palpate::skills
