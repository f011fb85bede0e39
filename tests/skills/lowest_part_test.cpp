// SPDX-License-Identifier: Apache-2.0
#include "skills/motion/lowest_part.hpp"

#include <gtest/gtest.h>

#include "skills/soft_shadow.hpp"

namespace palpate::skills {
namespace {

/// A hand of two balls, one of which hangs below the other where the hand is flat.
hand::Description two_balls(double below, double radius) {
  hand::Description hand = soft_shadow();
  const hand::FlatHand& flat = hand.postures.flat;
  const auto T_mount_link =
      hand::forward_kinematics(hand, hand::joints_in_free_flexion(hand, flat.positions));
  hand::MountPosition mount;
  mount.ypr << 0, flat.attitude.pitch, flat.attitude.roll;
  const Eigen::Vector3d up = mount.pose().linear().row(2);
  const Eigen::Vector3d center(0.02, -0.01, 0.03);  // in the mount
  hand.spheres.resize(2);
  hand.spheres[0] = {0, T_mount_link[0].inverse() * center, radius};
  hand.spheres[1] = {1, T_mount_link[1].inverse() * (center - below * up), radius};
  return hand;
}

TEST(LowestPart, AHandIsAsHollowAsItsFingersHangBelowItsHighestLink) {
  EXPECT_NEAR(hollow_depth(two_balls(0.07, 0.01)), 0.07, 1e-9);
  EXPECT_NEAR(hollow_depth(two_balls(0.07, 0.02)), 0.07, 1e-9);
  EXPECT_NEAR(hollow_depth(two_balls(-0.04, 0.01)), 0.04, 1e-9) << "the other one hangs below";
}

TEST(LowestPart, IsLowerByTheRadiusAndOnlyOfTheLinksThatCount) {
  const hand::Description small = two_balls(0.07, 0.01), big = two_balls(0.07, 0.02);
  const auto& flat = small.postures.flat;
  const double low = lowest_part(small, flat.positions, flat.attitude);
  EXPECT_NEAR(lowest_part(big, flat.positions, flat.attitude), low - 0.01, 1e-9);
  EXPECT_NEAR(lowest_part(small, flat.positions, flat.attitude, [](int link) { return link == 0; }),
              low + 0.07, 1e-9);
}

}  // namespace
}  // namespace palpate::skills
