// SPDX-License-Identifier: Apache-2.0
#include "palpate/grasping/closing_law.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "hand/descriptions.hpp"

namespace palpate::grasping {
namespace {

/// The Shadow hand with weak actuators, of which all reach as far.
hand::Description soft_hand() {
  hand::Description hand = hand::shadow_hand();
  for (hand::Actuator& actuator : hand.actuators) {
    actuator.stiffness = 2.0;
    actuator.command = {-0.5, 1.5};
  }
  return hand;
}

/// Where all actuators end, but for the thumb's base.
hand::ActuatorVector closed(double thumb_base) {
  hand::ActuatorVector positions = hand::ActuatorVector::Constant(hand::kShadowActuators, 1.5);
  positions[hand::shadow_hand().actuator("THJ5")] = thumb_base;
  return positions;
}

hand::ActuatorVector torques(double limit, int actuators = hand::kShadowActuators) {
  return hand::ActuatorVector::Constant(actuators, limit);
}

constexpr hand::PerFinger<bool> kAll = {true, true, true, true, true};

TEST(Closing, FreeFingerMovesAtTheRate) {
  const ClosingLaw law(soft_hand(), 2.0, closed(1.0));
  hand::HandCommand command = hand::resting_command();
  for (int i = 0; i < 10; ++i) law.advance(command, hand::resting_reading(), torques(0.25), kAll);
  EXPECT_NEAR(command.positions[hand::shadow_hand().actuator("FFJ3")], 10 * 2.0 * hand::kTick,
              1e-12);
  EXPECT_NEAR(command.positions[hand::shadow_hand().actuator("FFJ0")], 10 * 2.4 * hand::kTick,
              1e-12);
  EXPECT_EQ(command.positions[hand::shadow_hand().actuator("FFJ4")], 0.0);
}

TEST(Closing, BlockedFingerPressesWithTheLimit) {
  const ClosingLaw law(soft_hand(), 2.0, closed(1.0));
  const int j3 = hand::shadow_hand().actuator("MFJ3");
  const double blocked_at = 0.3;
  hand::HandCommand command = hand::resting_command();
  hand::HandReading reading = hand::resting_reading();
  for (int i = 0; i < 200; ++i) {
    reading.torques[j3] = std::max(0.0, 2.0 * (command.positions[j3] - blocked_at));
    law.advance(command, reading, torques(0.25), kAll);
  }
  EXPECT_NEAR(2.0 * (command.positions[j3] - blocked_at), 0.25, 1e-9);
}

TEST(Closing, GivesWayWhenTheObjectPushesBack) {
  const ClosingLaw law(soft_hand(), 2.0, closed(1.0));
  const int j3 = hand::shadow_hand().actuator("RFJ3");
  hand::HandCommand command = hand::resting_command();
  command.positions[j3] = 0.5;
  hand::HandReading reading = hand::resting_reading();
  reading.torques[j3] = 0.5;  // twice the limit
  law.advance(command, reading, torques(0.25), kAll);
  EXPECT_NEAR(command.positions[j3], 0.5 - 0.125, 1e-12);
}

TEST(Closing, StopsAtRangesAndLeavesInactiveFingersAlone) {
  const ClosingLaw law(soft_hand(), 2.0, closed(0.2));
  hand::HandCommand command = hand::resting_command();
  for (int i = 0; i < 500; ++i) {
    law.advance(command, hand::resting_reading(), torques(0.25), {true, true, false, true, true});
  }
  EXPECT_EQ(command.positions[hand::shadow_hand().actuator("FFJ3")], 1.5);
  EXPECT_EQ(command.positions[hand::shadow_hand().actuator("THJ5")], 0.2);
  EXPECT_EQ(command.positions[hand::shadow_hand().actuator("MFJ3")], 0.0);
}

TEST(Closing, OfNegativeSpeedGoesTowardsSmallerAngles) {
  const hand::Description gripper = hand::two_finger_hand();
  const hand::ActuatorVector closed{{-1.8, 1.2}};
  const ClosingLaw law(gripper, 2.0, closed);
  hand::HandCommand command = hand::resting_command(gripper);
  const hand::HandReading reading = hand::resting_reading(gripper);
  law.advance(command, reading, torques(0.25, 2), kAll);
  EXPECT_NEAR(command.positions[0], -0.5 * 2.0 * hand::kTick, 1e-12);
  EXPECT_NEAR(command.positions[1], 2.0 * hand::kTick, 1e-12);
  for (int i = 0; i < 500; ++i) law.advance(command, reading, torques(0.25, 2), kAll);
  EXPECT_EQ(command.positions, closed);
}

TEST(Closing, OfNegativeSpeedPressesWithTheLimitAndGivesWay) {
  const hand::Description gripper = hand::two_finger_hand();
  const ClosingLaw law(gripper, 2.0, hand::ActuatorVector{{-2.4, 1.5}});
  constexpr double kBlockedAt = -0.3;
  const double stiffness = gripper.actuators[0].stiffness;
  hand::HandCommand command = hand::resting_command(gripper);
  hand::HandReading reading = hand::resting_reading(gripper);
  for (int i = 0; i < 200; ++i) {
    reading.torques[0] = std::min(0.0, stiffness * (command.positions[0] - kBlockedAt));
    law.advance(command, reading, torques(0.25, 2), kAll);
  }
  EXPECT_NEAR(stiffness * (command.positions[0] - kBlockedAt), -0.25, 1e-9);
  const double before = command.positions[0];
  reading.torques[0] = -0.5;  // twice the limit
  law.advance(command, reading, torques(0.25, 2), kAll);
  EXPECT_NEAR(command.positions[0], before + 0.25 / stiffness, 1e-12);
}

}  // namespace
}  // namespace palpate::grasping
