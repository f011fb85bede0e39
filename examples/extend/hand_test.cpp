// SPDX-License-Identifier: Apache-2.0
// Add a hand: its model file becomes a description, and a driver implements step().
#include <gtest/gtest.h>

#include <algorithm>

#include "hand_over_floor.hpp"
#include "palpate/simulation/hand/describe_hand.hpp"
#include "palpate/skills/executor.hpp"

namespace palpate::hand {
namespace {

constexpr const char* kModel = PALPATE_EXAMPLES "/hands/three_fingers.xml";

TEST(OwnHand, IsDescribedByItsModelFile) {
  const simulation::DescribedHand described = simulation::describe_hand(kModel);
  EXPECT_TRUE(described.problems.empty());
  EXPECT_EQ(described.hand.fingers.size(), 3);
  EXPECT_EQ(described.hand.joint_count(), 9);
}

TEST(OwnHand, IsMovedByItsDriverUntilItTouches) {
  const Description model = simulation::describe_hand(kModel).hand;
  HandOverFloor hand(model, -0.1);
  HandCommand start;
  start.positions = ActuatorVector::Zero(model.actuator_count());
  skills::Executor robot(hand, model, start);
  const auto touches = [](const HandReading& reading) {
    return std::ranges::any_of(reading.contacts, [](const auto& tip) { return !tip.empty(); });
  };
  EXPECT_EQ(robot.move_mount({{0, 0, -0.2}}, 0.05, touches), skills::MotionEnd::stopped);
  EXPECT_FALSE(robot.fault()) << robot.fault().detail;
}

}  // namespace
}  // namespace palpate::hand
