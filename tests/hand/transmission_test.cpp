// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "hand/descriptions.hpp"
#include "palpate/core/random.hpp"
#include "palpate/hand/kinematics.hpp"

namespace palpate::hand {
namespace {

constexpr Coupling kCoupling;

Range middle_range() {
  return shadow_hand().joints[static_cast<std::size_t>(shadow_hand().joint("FFJ2"))].range;
}

TEST(Coupling, MiddleJointGoesFirstThenBoth) {
  const CoupledAngles start = share_in_free_flexion(0.3, kCoupling);
  EXPECT_DOUBLE_EQ(start.j2, 0.3);
  EXPECT_DOUBLE_EQ(start.j1, 0.0);
  const CoupledAngles later = share_in_free_flexion(kCoupling.follow_angle + 1.0, kCoupling);
  EXPECT_DOUBLE_EQ(later.j2, kCoupling.follow_angle + 0.5);
  EXPECT_DOUBLE_EQ(later.j1, 0.5);
}

TEST(Coupling, ClosedMeansBothAtTheirEnds) {
  const double end = middle_range().high;
  const CoupledAngles closed = share_in_free_flexion(2 * end, kCoupling);
  EXPECT_DOUBLE_EQ(closed.j2, end);
  EXPECT_DOUBLE_EQ(closed.j1, end);
}

TEST(Coupling, DistalNeverExceedsMiddleAndNeitherTurnsBack) {
  const double end = middle_range().high;
  CoupledAngles before = share_in_free_flexion(0, kCoupling);
  for (double j0 = 0; j0 <= 2 * end; j0 += 0.01) {
    const CoupledAngles now = share_in_free_flexion(j0, kCoupling);
    EXPECT_LE(now.j1, now.j2 + 1e-12);
    EXPECT_LE(now.j2, end + 1e-12);
    EXPECT_GE(now.j1, before.j1 - 1e-12);
    EXPECT_GE(now.j2, before.j2 - 1e-12);
    before = now;
  }
}

TEST(Coupling, MiddleAngleDeterminesThePair) {
  for (double j2 = 0; j2 < 1.55; j2 += 0.05) {
    EXPECT_NEAR(share_in_free_flexion(j0_for_middle(j2, kCoupling), kCoupling).j2, j2, 1e-12);
  }
}

TEST(Transmission, FreeFlexionInvertsActuatorPositions) {
  RandomStream random(3);
  for (const Description& hand : {shadow_hand(), two_finger_hand()}) {
    for (int trial = 0; trial < 100; ++trial) {
      ActuatorVector positions(hand.actuator_count());
      for (double& position : positions) position = random.uniform(0.0, 3.0);
      const JointVector joints = joints_in_free_flexion(hand, positions);
      EXPECT_EQ(joints.size(), hand.joint_count());
      EXPECT_LT((actuator_positions(hand, joints) - positions).norm(), 1e-12) << hand.name;
    }
  }
}

TEST(Transmission, GearsMultiplyAndSharesAndOffsetsDivide) {
  const Description gripper = two_finger_hand();
  // thumb: gear 2; finger: the inner joint alone, of which the outer takes half and 0.1 rad.
  const ActuatorVector positions = actuator_positions(gripper, JointVector{{-0.4, 0.6, 5.0}});
  EXPECT_TRUE(positions.isApprox(ActuatorVector{{-0.8, 0.6}}, 1e-15)) << positions.transpose();
  const JointVector joints = joints_in_free_flexion(gripper, ActuatorVector{{-0.8, 0.6}});
  EXPECT_TRUE(joints.isApprox(JointVector{{-0.4, 0.6, 0.4}}, 1e-15)) << joints.transpose();
}

TEST(Transmission, AJointThatNothingDrivesStaysAtZero) {
  Description gripper = two_finger_hand();
  gripper.actuators[1].joints.pop_back();
  EXPECT_EQ(joints_in_free_flexion(gripper, ActuatorVector{{-0.8, 0.6}})[2], 0);
}

}  // namespace
}  // namespace palpate::hand
