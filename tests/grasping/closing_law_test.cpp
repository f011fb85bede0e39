// SPDX-License-Identifier: Apache-2.0
#include "palpate/grasping/closing_law.hpp"

#include <gtest/gtest.h>

#include "palpate/hand/shadow.hpp"

namespace palpate::grasping {
namespace {

std::vector<hand::Actuator> soft_actuators() {
  std::vector<hand::Actuator> actuators;
  actuators.fill({2.0, {-0.5, 1.5}, 1.0});
  return actuators;
}

constexpr hand::PerFinger<bool> kAll = {true, true, true, true, true};

TEST(Closing, FreeFingerMovesAtTheRate) {
  const ClosingLaw law(soft_actuators(), 2.0, 1.0);
  hand::HandCommand command;
  for (int i = 0; i < 10; ++i) law.advance(command, {}, {}, kAll);
  EXPECT_NEAR(command.positions[hand::shadow_hand().actuator("FFJ3")], 10 * 2.0 * hand::kTick,
              1e-12);
  EXPECT_NEAR(command.positions[hand::shadow_hand().actuator("FFJ0")], 10 * 2.4 * hand::kTick,
              1e-12);
  EXPECT_EQ(command.positions[hand::shadow_hand().actuator("FFJ4")], 0.0);
}

TEST(Closing, BlockedFingerPressesWithTheLimit) {
  const auto actuators = soft_actuators();
  const ClosingLaw law(actuators, 2.0, 1.0);
  const int j3 = hand::shadow_hand().actuator("MFJ3");
  const double blocked_at = 0.3;
  hand::HandCommand command;
  hand::HandReading reading;
  for (int i = 0; i < 200; ++i) {
    reading.torques[j3] = std::max(0.0, 2.0 * (command.positions[j3] - blocked_at));
    law.advance(command, reading, {.proximal = 0.25}, kAll);
  }
  EXPECT_NEAR(2.0 * (command.positions[j3] - blocked_at), 0.25, 1e-9);
}

TEST(Closing, GivesWayWhenTheObjectPushesBack) {
  const ClosingLaw law(soft_actuators(), 2.0, 1.0);
  const int j3 = hand::shadow_hand().actuator("RFJ3");
  hand::HandCommand command;
  command.positions[j3] = 0.5;
  hand::HandReading reading;
  reading.torques[j3] = 0.5;  // twice the limit
  law.advance(command, reading, {.proximal = 0.25}, kAll);
  EXPECT_NEAR(command.positions[j3], 0.5 - 0.125, 1e-12);
}

TEST(Closing, StopsAtRangesAndLeavesInactiveFingersAlone) {
  const ClosingLaw law(soft_actuators(), 2.0, 0.2);
  hand::HandCommand command;
  for (int i = 0; i < 500; ++i) law.advance(command, {}, {}, {true, true, false, true, true});
  EXPECT_EQ(command.positions[hand::shadow_hand().actuator("FFJ3")], 1.5);
  EXPECT_EQ(command.positions[hand::shadow_hand().actuator("THJ5")], 0.2);
  EXPECT_EQ(command.positions[hand::shadow_hand().actuator("MFJ3")], 0.0);
}

TEST(Closing, BlendIsLinear) {
  const ClosingTorque mixed = blend({0.0, 1.0, 2.0, 3.0}, {1.0, 1.0, 0.0, 7.0}, 0.25);
  EXPECT_DOUBLE_EQ(mixed.proximal, 0.25);
  EXPECT_DOUBLE_EQ(mixed.distal, 1.0);
  EXPECT_DOUBLE_EQ(mixed.thumb, 1.5);
  EXPECT_DOUBLE_EQ(mixed.thumb_distal, 4.0);
}

}  // namespace
}  // namespace palpate::grasping
