// SPDX-License-Identifier: Apache-2.0
#include "palpate/estimation/held_pose_follower.hpp"

#include <gtest/gtest.h>

#include "estimation/box_in_hand.hpp"
#include "palpate/hand/kinematics.hpp"

namespace palpate::estimation {
namespace {

class HeldPoseFollowerTest : public BoxInHandTest {
 protected:
  HeldPoseFollowerTest() {
    options.fingers = 1;
    options.period = 0.05;
    options.estimation.free_space = false;
  }

  /// A reading whose first finger, bent by so much (rad), touches a face that looks to the right
  /// (+x); the mount stays where it is.
  hand::HandReading touching(double bend) {
    hand::HandReading result = reading({0, 0, 0}, false);
    result.joints[hand.joint("FFJ3")] = bend;
    const Eigen::Isometry3d T_mount_tip = tip_pose(result);
    const Eigen::Vector3d n = T_mount_tip.linear().transpose() * Eigen::Vector3d::UnitX();
    const Eigen::Vector3d p = hand.fingers[1].tip.b - hand.fingers[1].tip.radius * n;
    result.contacts[1] = {{.p = p, .n = n, .f = -2 * n}};
    return result;
  }

  /// Where it touches.
  Eigen::Vector3d spot(double bend) {
    const hand::HandReading sensed = touching(bend);
    return tip_pose(sensed) * sensed.contacts[1][0].p;
  }

  Eigen::Isometry3d tip_pose(const hand::HandReading& sensed) const {
    const auto tip = static_cast<std::size_t>(hand.fingers[1].link);
    return hand::forward_kinematics(hand, sensed.joints)[tip];
  }

  /// The box upright, with the middle of its right face at a place.
  localization::Posterior box_left_of(const Eigen::Vector3d& place) const {
    const double half = geometry::bounds(object.object().mesh).sizes().x() / 2;
    return at(place - half * Eigen::Vector3d::UnitX());
  }

  HeldPoseFollower follower() const { return {object, hand, options, 1}; }

  HeldPoseOptions options;
};

TEST_F(HeldPoseFollowerTest, GoesWithThePalmWhileFingersTouch) {
  HeldPoseFollower held = follower();
  held.update(reading({0, 0, 0.3}, true));
  EXPECT_TRUE(held.posterior().modes.empty());
  held.begin(at({0.1, 0, 0.05}));
  held.update(reading({0.02, 0, 0.4}, true));
  const Eigen::Vector3d carried(0.12, 0, 0.15);
  EXPECT_LT((held.posterior().modes.at(0).T_frame_object.translation() - carried).norm(), 1e-12);
  held.update(reading({0.5, 0, 0.4}, false));  // for a moment none touches: it stays where it was
  const Eigen::Vector3d now = held.posterior().modes.at(0).T_frame_object.translation();
  EXPECT_LT((now - carried).norm(), 1e-12);
}

// The palm moves on, and no finger touches, while an estimate is made.
TEST_F(HeldPoseFollowerTest, AnEstimateGoesWithTheObjectNotWithThePalm) {
  HeldPoseFollower held = follower();
  held.update(reading({0, 0, 0.3}, true));
  const auto task = held.task();
  held.update(reading({0, 0, 0.35}, true));
  held.update(reading({0.3, 0, 0.35}, false));
  HeldPoseEstimate estimate;
  estimate.posterior = at({0.1, 0, 0.05});
  held.accept(task, estimate);
  const Eigen::Vector3d now = held.posterior().modes.at(0).T_frame_object.translation();
  EXPECT_LT((now - Eigen::Vector3d(0.1, 0, 0.1)).norm(), 1e-12);
}

TEST_F(HeldPoseFollowerTest, ForgetsWhatNoFingerTouches) {
  HeldPoseFollower held = follower();
  held.update(reading({0, 0, 0.3}, true));
  held.begin(at({0.1, 0, 0.05}));
  const auto task = held.task();
  const int until_lost = static_cast<int>(options.lost_after / hand::kTick) + 2;
  for (int i = 0; i < until_lost; ++i) held.update(reading({0, 0, 0.3}, false));
  EXPECT_TRUE(held.posterior().modes.empty());
  HeldPoseEstimate late;  // of before the loss
  late.posterior = at({0.1, 0, 0.05});
  held.accept(task, late);
  EXPECT_TRUE(held.posterior().modes.empty());
}

TEST_F(HeldPoseFollowerTest, ForgetsWhatItHasNotHeardOfForLong) {
  HeldPoseFollower held = follower();
  held.update(reading({0, 0, 0.3}, true));
  held.begin(at({0.1, 0, 0.05}));
  tick += static_cast<int>(2 * options.lost_after / hand::kTick);
  held.update(reading({0, 0, 0.3}, true));
  EXPECT_TRUE(held.posterior().modes.empty());
  EXPECT_TRUE(held.due());
  EXPECT_EQ(held.task().log.readings.size(), 1U);  // what it may hold now is another object
}

TEST_F(HeldPoseFollowerTest, BeginsAgainWhereTheClockIsSetBack) {
  HeldPoseFollower held = follower();
  tick = 60000;
  held.update(reading({0, 0, 0.3}, true));
  held.begin(at({0.1, 0, 0.05}));
  held.task();
  EXPECT_FALSE(held.due());
  tick = 3;
  held.update(reading({0, 0, 0.3}, true));
  EXPECT_TRUE(held.posterior().modes.empty());
  EXPECT_TRUE(held.due());
  EXPECT_EQ(held.task().log.readings.size(), 1U);
}

TEST_F(HeldPoseFollowerTest, ContactsThatStayTellNothingNew) {
  HeldPoseFollower held = follower();
  held.update(touching(0));
  held.begin(box_left_of(spot(0)));
  held.update(touching(0));
  EXPECT_TRUE(held.task().known);
  for (int i = 0; i < 20; ++i) held.update(touching(0.1));
  const auto task = held.task();
  EXPECT_FALSE(task.known);
  EXPECT_TRUE(task.prior);
}

TEST_F(HeldPoseFollowerTest, ASlipIsFoundWhereAFingerTouchesElsewhere) {
  constexpr double kSlip = 0.004;
  HeldPoseFollower held = follower();
  held.update(touching(0));
  held.begin(box_left_of(spot(0.1) - kSlip * Eigen::Vector3d::UnitX()));
  const double before = held.posterior().modes.at(0).T_frame_object.translation().x();
  for (int i = 0; i < 20; ++i) held.update(touching(0.1));
  ASSERT_TRUE(held.due());
  const auto task = held.task();
  held.accept(task, held.estimate(task));
  ASSERT_FALSE(held.posterior().modes.empty());
  const double after = held.posterior().modes[0].T_frame_object.translation().x();
  EXPECT_NEAR(after - before, kSlip, 0.002);
}

}  // namespace
}  // namespace palpate::estimation
