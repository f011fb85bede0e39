// SPDX-License-Identifier: Apache-2.0
#include "palpate/hand/self_clearance.hpp"

#include <gtest/gtest.h>

#include <numbers>

namespace palpate::hand {
namespace {

/// Two fingers side by side, 40 mm apart, each a link of 30 mm with a ball at its end, which turn
/// towards one another.
Description two_fingers() {
  Description hand;
  hand.links = {{.name = "palm"}};
  hand.palm = 0;
  for (const double side : {-0.02, 0.02}) {
    const int finger = hand.finger_count(), link = static_cast<int>(hand.links.size());
    hand.joints.push_back({"joint " + std::to_string(finger), {-2, 2}});
    hand::Link one{.name = "link " + std::to_string(finger), .parent = 0};
    one.T_parent_link.translation() << 0, side, 0;
    one.axis = Eigen::Vector3d::UnitZ() * (side < 0 ? 1 : -1);
    one.joint = finger;
    hand.links.push_back(one);
    hand.fingers.push_back({one.name, link, {}});
    hand.spheres.push_back({link, {0.03, 0, 0}, 0.005});
  }
  return hand;
}

JointVector both(double angle) { return JointVector::Constant(2, angle); }

TEST(SelfClearance, FingersThatMeetAreNotClear) {
  const Description hand = two_fingers();
  const SelfClearance clearance(hand, both(0));
  EXPECT_TRUE(clearance.is_clear(both(0)));
  // 30 mm sin(15 deg) = 7.8 mm nearer each, 30 deg: 15 mm, where 10 mm are left between the balls.
  EXPECT_TRUE(clearance.is_clear(both(15 * std::numbers::pi / 180)));
  EXPECT_FALSE(clearance.is_clear(both(30 * std::numbers::pi / 180)));
}

TEST(SelfClearance, LinksThatAreCloseInAPossiblePostureMayBe) {
  const Description hand = two_fingers();
  const SelfClearance clearance(hand, both(30 * std::numbers::pi / 180));
  EXPECT_TRUE(clearance.is_clear(both(35 * std::numbers::pi / 180)));
}

TEST(SelfClearance, LinksOfOneFingerMayMeet) {
  Description hand = two_fingers();
  hand::Link outer{.name = "outer", .parent = 1};
  outer.T_parent_link.translation() << 0.03, 0, 0;
  outer.axis = Eigen::Vector3d::UnitZ();
  outer.joint = hand.joint_count();
  hand.joints.push_back({"outer", {-3, 3}});
  hand.links.push_back(outer);
  hand.fingers[0].link = 3;
  hand.spheres.push_back({3, {0.02, 0, 0}, 0.005});
  const SelfClearance clearance(hand, JointVector::Zero(3));
  JointVector folded = JointVector::Zero(3);
  folded[2] = -2.9;  // the outer ball comes back to 11 mm from the knuckle, 3 mm into the inner one
  hand.spheres[0].center.x() = 0.018;
  EXPECT_TRUE(clearance.is_clear(folded));
}

}  // namespace
}  // namespace palpate::hand
