// SPDX-License-Identifier: Apache-2.0
#include "palpate/hand/arm_follower.hpp"

#include <gtest/gtest.h>

#include <stdexcept>
#include <vector>

namespace palpate::hand {
namespace {

/// A link of 0.3 m that turns about the vertical.
ArmDescription turntable() {
  ArmDescription arm;
  arm.name = "turntable";
  arm.links = {{"beam", -1, Eigen::Isometry3d::Identity(), Eigen::Vector3d::UnitZ(), 0}};
  arm.joints = {{"pan", {-1, 1}}};
  arm.flange = 0;
  arm.T_world_stand.translation().z() = 0.3;
  arm.T_flange_mount.translation().x() = 0.3;
  return arm;
}

TEST(ArmFollower, FollowsOnlyOnceItHasBeenReset) {
  ArmFollower follower(turntable());
  const Eigen::Isometry3d start = mount_pose(follower.arm(), ArmVector::Zero(1));
  const std::vector<MountPosition> way = {MountPosition::at(start)};
  EXPECT_THROW(follower.follow(start), std::logic_error);
  EXPECT_THROW(static_cast<void>(follower.check_path(way)), std::logic_error);
  follower.reset(start);
  EXPECT_NEAR(follower.follow(start)[0], 0, 1e-4);
  EXPECT_TRUE(follower.check_path(way).obstacle.empty());
}

}  // namespace
}  // namespace palpate::hand
