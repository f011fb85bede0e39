// SPDX-License-Identifier: Apache-2.0
#include "skills/grasp/closing_watch.hpp"

#include <gtest/gtest.h>

#include "hand/fake_hand.hpp"

namespace palpate::skills {
namespace {

const hand::Description kHand = hand::with_soft_actuators();
constexpr int kFinger = 2;
const int kDrive = hand::closing_actuators(kHand, kFinger).front();
const hand::ActuatorVector kContactTorque =
    hand::ActuatorVector::Constant(kHand.actuator_count(), 0.1);

hand::HandReading reading_of(double torque, bool sensed) {
  hand::HandReading reading = hand::resting_reading(kHand);
  const bool closes_up = kHand.actuators[static_cast<std::size_t>(kDrive)].closing > 0;
  reading.torques[kDrive] = closes_up ? torque : -torque;
  const Eigen::Vector3d up = Eigen::Vector3d::UnitZ();
  if (sensed) reading.contacts[static_cast<std::size_t>(kFinger)] = {{0.01 * up, up, -up}};
  return reading;
}

/// Ticks until it is noticed that one finger is held up; -1: it never is.
int ticks_until_noticed(double torque, double friction, bool sensed) {
  UnsensedContacts unsensed(kHand, kContactTorque);
  const hand::ActuatorVector frictions = reading_of(friction, false).torques;
  for (int tick = 1; tick <= 50; ++tick) {
    const auto fingers = unsensed.update(reading_of(torque, sensed), frictions);
    if (fingers == std::vector{kFinger}) return tick;
    EXPECT_TRUE(fingers.empty());
  }
  return -1;
}

TEST(UnsensedContacts, IsNoticedOnceItHasPressedForAWhile) {
  EXPECT_EQ(ticks_until_noticed(0.08, 0, false), 10);
}

TEST(UnsensedContacts, FrictionIsNoPress) {
  EXPECT_EQ(ticks_until_noticed(0.08, 0.05, false), -1);
  EXPECT_EQ(ticks_until_noticed(0.14, 0.05, false), 10);
}

TEST(UnsensedContacts, AFingerThatSensesIsNotInDoubt) {
  EXPECT_EQ(ticks_until_noticed(0.2, 0, true), -1);
}

TEST(UnsensedContacts, TheDoubtEndsWithTheTorque) {
  UnsensedContacts unsensed(kHand, kContactTorque);
  const hand::ActuatorVector none = hand::ActuatorVector::Zero(kHand.actuator_count());
  for (int tick = 1; tick <= 100; ++tick) {
    EXPECT_TRUE(unsensed.update(reading_of(tick % 9 == 0 ? 0 : 0.2, false), none).empty());
  }
}

/// A reading in which those fingers touch.
hand::HandReading touching(const hand::PerFinger<bool>& fingers) {
  hand::HandReading reading = hand::resting_reading(kHand);
  const Eigen::Vector3d up = Eigen::Vector3d::UnitZ();
  for (std::size_t finger = 0; finger < fingers.size(); ++finger) {
    if (fingers[finger]) reading.contacts[finger] = {{0.01 * up, up, -up}};
  }
  return reading;
}

/// Fingers whose commands move on at every tick; the others have been stopped.
class ClosingFingers {
 public:
  explicit ClosingFingers(const hand::PerFinger<bool>& closing) : done(kHand) {
    for (int finger = 0; finger < kHand.finger_count(); ++finger) {
      if (!closing[static_cast<std::size_t>(finger)]) done.stop(finger);
    }
    command.positions = hand::ActuatorVector::Zero(kHand.actuator_count());
  }

  void touch(const hand::PerFinger<bool>& fingers, int ticks) {
    for (int i = 0; i < ticks; ++i) {
      command.positions.array() += 0.01;
      done.update(touching(fingers), command);
    }
  }

  hand::HandCommand command;
  FingersDone done;
};

constexpr hand::PerFinger<bool> kThumbAndFirst = {true, true}, kFirst = {false, true},
                                kThumb = {true}, kNone = {};

TEST(FingersDone, AFingerThatHasLostTouchWaitsUntilAllHaveMet) {
  ClosingFingers fingers(kThumbAndFirst);
  fingers.touch(kFirst, 3);
  EXPECT_TRUE(fingers.done.done(1));
  fingers.touch(kNone, 50);  // it has pushed the object away
  EXPECT_TRUE(fingers.done.done(1));
  EXPECT_FALSE(fingers.done.done(0));
  fingers.touch(kThumb, 20);  // the last one has met it as well
  EXPECT_TRUE(fingers.done.done(0));
  EXPECT_FALSE(fingers.done.done(1));
  EXPECT_FALSE(fingers.done.settled());
  fingers.touch(kThumbAndFirst, 20);
  EXPECT_TRUE(fingers.done.settled());
}

TEST(FingersDone, AFingerThatWaitsIsNotStuck) {
  ClosingFingers fingers(kThumbAndFirst);
  fingers.touch(kFirst, 3);
  for (int i = 0; i < 50; ++i) {  // it stands still, for it waits
    for (const int drive : hand::closing_actuators(kHand, 0))
      fingers.command.positions[drive] += 0.01;
    fingers.done.update(touching(kNone), fingers.command);
  }
  fingers.touch(kThumb, 20);
  EXPECT_FALSE(fingers.done.done(1));
}

TEST(FingersDone, ATouchThatDoesNotLastEndsNothing) {
  ClosingFingers fingers(kThumbAndFirst);
  fingers.touch(kFirst, 3);
  fingers.touch(kThumb, 1);
  fingers.touch(kFirst, 50);
  EXPECT_FALSE(fingers.done.settled());
  EXPECT_FALSE(fingers.done.done(0));
}

TEST(FingersDone, FingersThatLoseTouchAgainAndAgainDoNotPressForLong) {
  ClosingFingers fingers(kThumbAndFirst);
  fingers.touch(kThumbAndFirst, 3);
  int ticks = 3;
  for (; ticks < 1000 && !fingers.done.settled(); ticks += 20) {
    fingers.touch(kThumb, 15);  // for longer than a touch counts
    fingers.touch(kThumbAndFirst, 5);
  }
  EXPECT_GT(ticks, 200);
  EXPECT_LT(ticks, 400);
}

TEST(FingersDone, AFingerThatIsStoppedPushesNothing) {
  ClosingFingers fingers(kThumbAndFirst);
  fingers.touch(kFirst, 3);
  fingers.done.stop(0);
  EXPECT_FALSE(fingers.done.still_closing()[0]);
  fingers.touch(kFirst, 20);
  EXPECT_TRUE(fingers.done.settled());
}

}  // namespace
}  // namespace palpate::skills
