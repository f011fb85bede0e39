// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <limits>
#include <stdexcept>

#include "hand/fake_hand.hpp"
#include "palpate/hand/shadow.hpp"
#include "palpate/skills/executor.hpp"

namespace palpate::skills {
namespace {

using hand::HandReading;

const hand::Description kSoftHand = hand::with_soft_actuators();
constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

TEST(SafeState, AStoppedFingerHoldsOnLightly) {
  hand::FakeHand fake([](HandReading& reading) {
    reading.joints[hand::shadow_hand().joint("FFJ3")] = 0.2;  // it is held back there
    reading.base_force.z() = reading.time > 1 ? 90 : 0;
  });
  Executor robot(fake, kSoftHand, hand::resting_command());
  hand::ActuatorVector posture = hand::ActuatorVector::Zero(hand::kShadowActuators);
  posture[hand::shadow_hand().actuator("FFJ3")] = 0.7;
  robot.move_fingers(posture, 0.5);
  EXPECT_THROW(robot.wait(1), SafetyStop);
  const double torque = robot.command().positions[hand::shadow_hand().actuator("FFJ3")] - 0.2;
  EXPECT_NEAR(torque, SafetyOptions{}.rest_torque, 1e-9);  // the stiffness is 1 N m/rad
}

/// What hangs in the hand would fall.
TEST(SafeState, AStoppedHandKeepsWhatItHolds) {
  const int knuckle = hand::shadow_hand().actuator("FFJ3");
  for (const bool holds : {false, true}) {
    hand::FakeHand fake([](HandReading& reading) {
      reading.joints[hand::shadow_hand().joint("FFJ3")] = 0.2;  // it is held back there
      if (reading.time > 1) reading.base_force.x() = kNan;
    });
    Executor robot(fake, kSoftHand, hand::resting_command());
    hand::ActuatorVector posture = hand::ActuatorVector::Zero(hand::kShadowActuators);
    posture[knuckle] = 0.5;
    robot.move_fingers(posture, 0.5);
    if (holds) robot.add_event(estimation::TouchEvent::closed);
    EXPECT_THROW(robot.wait(1), SafetyStop);
    const double torque = robot.command().positions[knuckle] - 0.2;
    EXPECT_NEAR(torque, holds ? 0.3 : SafetyOptions{}.rest_torque, 1e-9);
  }
}

/// A hand that throws at every step after the first.
struct LostHand : hand::Hand {
  hand::FakeHand fake;
  int steps = 0;
  HandReading step(const hand::HandCommand& command) override {
    if (++steps > 1) throw std::runtime_error("the link is lost");
    return fake.step(command);
  }
};

TEST(SafeState, DrivesAreStoppedThoughTheHandKeepsThrowing) {
  LostHand lost;
  int stopped = 0;
  Executor robot(lost, kSoftHand, hand::resting_command(), {}, nullptr,
                 {{}, {}, [&] { ++stopped; }});
  EXPECT_THROW(robot.wait(0.1), SafetyStop);
  EXPECT_EQ(stopped, 1);
  EXPECT_GT(lost.steps, 10) << "the link may come back";
}

TEST(SafeState, WhoLooksOnCannotKeepTheHandFromGivingWay) {
  hand::FakeHand fake([](HandReading& reading) { reading.base.xyz.x() = 0; });  // it is blocked
  Executor::Observer observer;
  observer.on_tick = [](const HandReading& reading, const hand::HandCommand&) {
    if (reading.time > 0.5) throw std::runtime_error("the disk is full");
  };
  Executor robot(fake, kSoftHand, hand::resting_command(), observer);
  hand::BasePosition far;
  far.xyz.x() = 0.04;
  EXPECT_ANY_THROW(robot.move_base(far, 0.05));
  robot.make_safe(Fault::exception, "the disk is full");
  EXPECT_NEAR(robot.command().base.xyz.x(), 0, 1e-9);
}

}  // namespace
}  // namespace palpate::skills
