// SPDX-License-Identifier: Apache-2.0
#include "skills/safety/unsensed_force.hpp"

#include <gtest/gtest.h>

#include "hand/fake_hand.hpp"

namespace palpate::skills {
namespace {

constexpr double kForce = 6;  // N
const hand::Description kHand = hand::with_soft_actuators();
const int kKnuckle = kHand.actuator("THJ5");

hand::HandCommand command_at(double position) {
  hand::HandCommand command = hand::resting_command();
  command.positions[kKnuckle] = position;
  return command;
}

hand::HandReading reading_of(double torque, bool sensed) {
  hand::HandReading reading = hand::resting_reading(kHand);
  reading.torques[kKnuckle] = torque;
  const Eigen::Vector3d up = Eigen::Vector3d::UnitZ();
  if (sensed) reading.contacts[0] = {{0.01 * up, up, -0.5 * up}};
  return reading;
}

double most() {
  const auto& actuator = kHand.actuators[static_cast<std::size_t>(kKnuckle)];
  return kForce * actuator.lever + 0.1 * actuator.max_torque;
}

TEST(UnsensedForce, AFingerThatIsHeldUpAndSensesNothingPressesNoFurther) {
  UnsensedForce unsensed(kHand, kForce);
  const double stiffness = kHand.actuators[static_cast<std::size_t>(kKnuckle)].stiffness;
  for (const double side : {1.0, -1.0}) {
    for (int tick = 0; tick < 20; ++tick) {
      hand::HandCommand command = command_at(side * 0.5);
      unsensed.limit(command, command_at(side * 0.4), reading_of(side * (most() + 0.2), false));
      if (tick < 9) continue;
      EXPECT_NEAR(command.positions[kKnuckle], side * (0.4 - 0.2 / stiffness), 1e-12);
    }
  }
}

TEST(UnsensedForce, ItIsReportedOnceItHasLasted) {
  UnsensedForce unsensed(kHand, kForce);
  int first = -1;
  for (int tick = 0; tick < 40 && first < 0; ++tick) {
    hand::HandCommand command = command_at(0.5);
    const auto held_up = unsensed.limit(command, command_at(0.4), reading_of(most() + 0.2, false));
    if (!held_up.empty()) first = tick;
    if (first >= 0) {
      EXPECT_EQ(held_up, std::vector<int>{0});
    }
  }
  EXPECT_EQ(first, 18);  // ten readings without a contact, then ten ticks
}

/// A skill wants the same posture at every tick, and the torque follows from what is commanded.
TEST(UnsensedForce, AJammedJointIsReportedThoughTheLimitKeepsItsTorqueLow) {
  UnsensedForce unsensed(kHand, kForce);
  const double stiffness = kHand.actuators[static_cast<std::size_t>(kKnuckle)].stiffness;
  hand::HandCommand last = command_at(0);
  double torque = 0;
  bool reported = false;
  for (int tick = 0; tick < 100; ++tick) {
    torque = stiffness * last.positions[kKnuckle];  // it stands at 0
    hand::HandCommand command = command_at(last.positions[kKnuckle] + 0.02);
    reported |= !unsensed.limit(command, last, reading_of(torque, false)).empty();
    last = command;
  }
  EXPECT_TRUE(reported);
  EXPECT_NEAR(torque, most(), 0.01 * most());
}

TEST(UnsensedForce, AFingerThatSensesIsLeftAlone) {
  UnsensedForce unsensed(kHand, kForce);
  for (int tick = 0; tick < 40; ++tick) {
    hand::HandCommand command = command_at(0.5);
    EXPECT_TRUE(unsensed.limit(command, command_at(0.4), reading_of(most() + 1, true)).empty());
    EXPECT_EQ(command.positions[kKnuckle], 0.5);
  }
}

TEST(UnsensedForce, AFingerThatMovesFreelyIsLeftAlone) {
  UnsensedForce unsensed(kHand, kForce);
  for (int tick = 0; tick < 40; ++tick) {
    hand::HandCommand command = command_at(0.5);
    EXPECT_TRUE(unsensed.limit(command, command_at(0.4), reading_of(0.9 * most(), false)).empty());
    EXPECT_EQ(command.positions[kKnuckle], 0.5);
  }
}

}  // namespace
}  // namespace palpate::skills
