// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <functional>
#include <limits>
#include <optional>
#include <semaphore>
#include <stdexcept>
#include <stop_token>
#include <utility>
#include <vector>

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
    reading.mount_force.z() = reading.time > 1 ? 90 : 0;
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
      if (reading.time > 1) reading.mount_force.x() = kNan;
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
  hand::FakeHand fake([](HandReading& reading) { reading.mount.xyz.x() = 0; });  // it is blocked
  Executor::Observer observer;
  observer.on_tick = [](const HandReading& reading, const hand::HandCommand&) {
    if (reading.time > 0.5) throw std::runtime_error("the disk is full");
  };
  Executor robot(fake, kSoftHand, hand::resting_command(), observer);
  hand::MountPosition far;
  far.xyz.x() = 0.04;
  EXPECT_ANY_THROW(robot.move_mount(far, 0.05));
  robot.make_safe(Fault::exception, "the disk is full");
  EXPECT_NEAR(robot.command().mount.xyz.x(), 0, 1e-9);
}

/// No executor is made then, whose destructor could stop them.
TEST(SafeState, DrivesAreStoppedIfWhoLooksOnThrowsAtTheFirstReading) {
  hand::FakeHand fake;
  int stops = 0;
  Safety safety;
  safety.stop_drives = [&] { ++stops; };
  Executor::Observer observer;
  observer.on_tick = [](const auto&, const auto&) { throw std::runtime_error("the disk is full"); };
  EXPECT_THROW(Executor(fake, kSoftHand, hand::resting_command(), observer, nullptr, safety),
               std::runtime_error);
  EXPECT_EQ(stops, 1);
}

/// A hand whose 20th step hangs until its drives are stopped, and which keeps its commands.
struct StallingHand : hand::FakeHand {
  using FakeHand::FakeHand;
  HandReading step(const hand::HandCommand& command) override {
    commands.push_back(command);
    if (hangs && commands.size() == 20) stopped.acquire();
    return FakeHand::step(command);
  }
  bool hangs = false;
  std::binary_semaphore stopped{0};
  std::vector<hand::HandCommand> commands;
};

TEST(SafeState, DrivesThatCannotBeStoppedDoNotEndTheProgram) {
  StallingHand stalling;
  stalling.hangs = true;
  bool released = false;
  Safety safety;
  safety.options.watchdog = 0.5;
  safety.stop_drives = [&] {
    if (!std::exchange(released, true)) stalling.stopped.release();
    throw std::runtime_error("the relay does not answer");
  };
  Executor robot(stalling, kSoftHand, hand::resting_command(), {}, nullptr, safety);
  EXPECT_THROW(robot.wait(1), SafetyStop);
  EXPECT_EQ(robot.fault().fault, Fault::silent);
  EXPECT_GT(stalling.commands.size(), 40u) << "it is eased all the same";
}

TEST(SafeState, ARequestToStopLetsNoCommandPassTheGate) {
  std::stop_source source;
  StallingHand recording;
  Executor robot(recording, kSoftHand, hand::resting_command(), {}, nullptr,
                 {{}, source.get_token(), {}});
  robot.wait(0.1);
  source.request_stop();
  hand::HandCommand far = robot.command();
  far.mount.xyz.x() = 0.9;
  far.positions[3] = kNan;
  EXPECT_THROW(robot.follow(std::vector{far}), SafetyStop);
  EXPECT_EQ(robot.fault().fault, Fault::stop_requested);
  for (const auto& command : recording.commands) {
    EXPECT_TRUE(command.positions.allFinite());
    EXPECT_LT(command.mount.xyz.norm(), 1e-9);
  }
}

TEST(SafeState, AHandThatStandsElsewhereIsLeftThere) {
  StallingHand mount([](HandReading& reading) { reading.mount.xyz.x() = 0.4; });
  Executor robot(mount, kSoftHand, hand::resting_command());
  EXPECT_EQ(robot.fault().fault, Fault::not_at_start);
  EXPECT_EQ(to_string(robot.fault().fault), "not_at_start");
  EXPECT_TRUE(robot.fault().detail.starts_with("the mount is 0.400 m")) << robot.fault().detail;
  EXPECT_THROW(robot.wait(0.1), SafetyStop);
  for (std::size_t i = 1; i < mount.commands.size(); ++i) {
    EXPECT_NEAR(mount.commands[i].mount.xyz.x(), 0.4, 1e-9);
  }
  StallingHand fist(
      [](HandReading& reading) { reading.joints[hand::shadow_hand().joint("FFJ3")] = 1.2; });
  Executor closed(fist, kSoftHand, hand::resting_command());
  EXPECT_EQ(closed.fault().fault, Fault::not_at_start);
  EXPECT_TRUE(closed.fault().detail.starts_with("FFJ3 is at 1.20 rad")) << closed.fault().detail;
}

/// A hand that can tell where it stands before it is commanded.
struct SensingHand : StallingHand {
  std::optional<HandReading> sense() override {
    ++senses;
    HandReading reading = hand::resting_reading(kSoftHand);
    reading.torques[0] = 0.001;  // no hand reads zeros alone
    reading.mount_force.x() = 0.01;
    if (script) script(reading);
    return reading;
  }
  std::function<void(HandReading&)> script;
  int senses = 0;
};

TEST(FirstReading, IsSensedBeforeTheFirstCommand) {
  SensingHand sensing;
  Executor robot(sensing, kSoftHand, hand::resting_command());
  EXPECT_FALSE(robot.fault());
  EXPECT_EQ(sensing.senses, 1);
  EXPECT_EQ(sensing.commands.size(), 1u);
  ASSERT_EQ(robot.log().readings.size(), 2u);
  EXPECT_EQ(robot.log().readings[0].mount_force.x(), 0.01);
}

TEST(FirstReading, OfAHandThatStandsElsewhereLetsNoCommandPass) {
  int stops = 0;
  Safety safety;
  safety.stop_drives = [&] { ++stops; };
  SensingHand sensing;
  sensing.script = [](HandReading& reading) { reading.mount.xyz.x() = 0.4; };
  Executor robot(sensing, kSoftHand, hand::resting_command(), {}, nullptr, safety);
  EXPECT_EQ(robot.fault().fault, Fault::not_at_start);
  EXPECT_THROW(robot.wait(0.1), SafetyStop);
  EXPECT_TRUE(sensing.commands.empty());
  EXPECT_EQ(stops, 1);
}

TEST(FirstReading, OfZerosAloneIsOfAHandThatWasNotHeard) {
  SensingHand sensing;
  sensing.script = [](HandReading& reading) { reading = hand::resting_reading(kSoftHand); };
  Executor robot(sensing, kSoftHand, hand::resting_command());
  EXPECT_EQ(robot.fault().fault, Fault::silent);
  EXPECT_TRUE(sensing.commands.empty());
}

TEST(FirstReading, ThatCannotBeUsedIsAskedForAgain) {
  SensingHand sensing;
  sensing.script = [&](HandReading& reading) {
    if (sensing.senses < 3) reading.joints[2] = kNan;
  };
  Executor robot(sensing, kSoftHand, hand::resting_command());
  EXPECT_FALSE(robot.fault());
  EXPECT_EQ(sensing.senses, 3);
  SensingHand broken;
  broken.script = [](HandReading& reading) { reading.joints[2] = kNan; };
  Executor stopped(broken, kSoftHand, hand::resting_command());
  EXPECT_EQ(stopped.fault().fault, Fault::not_finite);
  EXPECT_TRUE(broken.commands.empty());
}

TEST(FirstReading, OfAHandThatThrowsIsAFault) {
  SensingHand sensing;
  sensing.script = [](HandReading&) { throw std::runtime_error("no connection"); };
  Executor robot(sensing, kSoftHand, hand::resting_command());
  EXPECT_EQ(robot.fault().fault, Fault::exception);
  EXPECT_EQ(robot.fault().detail, "the hand: no connection");
  EXPECT_TRUE(sensing.commands.empty());
  sensing.script = [](HandReading&) { throw 7; };
  Executor other(sensing, kSoftHand, hand::resting_command());
  EXPECT_EQ(other.fault().detail, "the hand: an unknown exception");
}

}  // namespace
}  // namespace palpate::skills
