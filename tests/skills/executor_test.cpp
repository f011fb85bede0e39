// SPDX-License-Identifier: Apache-2.0
#include "palpate/skills/executor.hpp"

#include <gtest/gtest.h>

#include <chrono>
#include <limits>
#include <thread>

#include "hand/fake_hand.hpp"
#include "palpate/core/random.hpp"
#include "palpate/hand/shadow.hpp"
#include "palpate/hand/tip_forces.hpp"
#include "palpate/skills/phase.hpp"
#include "palpate/skills/stop_conditions.hpp"

namespace palpate::skills {
namespace {

using hand::HandReading;
using hand::kTick;

const hand::Description kSoftHand = hand::with_soft_actuators();

/// A robot at the origin whose hand senses what the script says.
struct Scene {
  explicit Scene(hand::FakeHand::Script script = {}, Executor::Observer observer = {})
      : hand(std::move(script)),
        robot(hand, kSoftHand, hand::resting_command(), std::move(observer)) {}
  hand::FakeHand hand;
  Executor robot;
};

hand::MountPosition at(const Eigen::Vector3d& xyz) { return {xyz, Eigen::Vector3d::Zero()}; }

TEST(Executor, MountComesToTheTargetAtTheGivenSpeed) {
  RandomStream random(1);
  for (int i = 0; i < 20; ++i) {
    Scene scene;
    const Eigen::Vector3d target = random.uniform(0.05, 0.3) * random.unit_vector();
    const double speed = random.uniform(0.02, 0.1);  // that is reached in a tick
    const double start = scene.robot.time();
    EXPECT_EQ(scene.robot.move_mount(at(target), speed), MotionEnd::reached);
    EXPECT_LT((scene.robot.reading().mount.xyz - target).norm(), 1e-12);
    EXPECT_NEAR(scene.robot.time() - start, target.norm() / speed, kTick);

    const auto& readings = scene.robot.log().readings;
    const double step = (readings[1].mount.xyz - readings[0].mount.xyz).norm();
    for (std::size_t k = 1; k < readings.size(); ++k) {
      const Eigen::Vector3d way = readings[k].mount.xyz - readings[k - 1].mount.xyz;
      EXPECT_NEAR(way.norm(), step, 1e-12);
      EXPECT_LT(way.cross(target).norm(), 1e-12);
    }
  }
}

TEST(Executor, TurningMountEndsTurned) {
  Scene scene;
  const hand::MountPosition target{{0.01, 0, 0}, {1.0, -0.5, 0.2}};
  scene.robot.move_mount(target, 0.1);
  EXPECT_LT((scene.robot.reading().mount.ypr - target.ypr).norm(), 1e-12);
  EXPECT_GT(scene.robot.time(), 1.0);  // the turn, not the 0.1 s of way, sets the pace
}

TEST(Executor, MotionStopsOnTheTickOfItsCondition) {
  Scene scene;
  const auto low = [](const HandReading& reading) { return reading.mount.xyz.z() <= -0.05; };
  EXPECT_EQ(scene.robot.move_mount(at({0, 0, -0.2}), 0.1, low), MotionEnd::stopped);
  EXPECT_LE(scene.robot.reading().mount.xyz.z(), -0.05);
  EXPECT_GT(scene.robot.reading().mount.xyz.z(), -0.0511);
  EXPECT_EQ(scene.robot.command().mount.xyz, scene.robot.reading().mount.xyz);
}

TEST(Executor, DeadlineEndsEveryMotion) {
  Scene scene;
  scene.robot.set_deadline(0.5);
  EXPECT_EQ(scene.robot.move_mount(at({1, 0, 0}), 0.1), MotionEnd::timed_out);
  EXPECT_NEAR(scene.robot.time(), 0.5, kTick);
  EXPECT_LT(scene.robot.reading().mount.xyz.x(), 0.051);
  EXPECT_EQ(scene.robot.wait(1.0), MotionEnd::timed_out);
  EXPECT_EQ(scene.robot.move_fingers(hand::ActuatorVector::Ones(hand::kShadowActuators), 1.0),
            MotionEnd::timed_out);
  EXPECT_NEAR(scene.robot.time(), 0.52, kTick);
  scene.robot.set_deadline(std::numeric_limits<double>::infinity());
  EXPECT_EQ(scene.robot.wait(0.1), MotionEnd::reached);
}

TEST(Executor, WaitsForItsTimeOrItsCondition) {
  Scene scene;
  const double start = scene.robot.time();
  EXPECT_EQ(scene.robot.wait(0.37), MotionEnd::reached);
  EXPECT_NEAR(scene.robot.time() - start, 0.37, 1e-9);
  const auto late = [](const HandReading& reading) { return reading.time > 0.5; };
  EXPECT_EQ(scene.robot.wait(10, late), MotionEnd::stopped);
  EXPECT_NEAR(scene.robot.time(), 0.51, 1e-9);
}

TEST(Executor, FingersComeToThePostureInTheGivenTime) {
  Scene scene;
  const double start = scene.robot.time();
  const hand::ActuatorVector posture = hand::ActuatorVector::Constant(hand::kShadowActuators, 0.7);
  EXPECT_EQ(scene.robot.move_fingers(posture, 0.5), MotionEnd::reached);
  EXPECT_NEAR(scene.robot.time() - start, 0.5, 1e-9);
  EXPECT_EQ(scene.robot.command().positions, posture);
  EXPECT_EQ(scene.robot.reading().joints[hand::shadow_hand().joint("FFJ3")], 0.7);
}

TEST(Executor, MountAndFingersArriveTogether) {
  for (const double seconds : {0.1, 2.0}) {
    Scene scene;
    const hand::ActuatorVector from = scene.robot.command().positions;
    hand::HandCommand target{from, at({0.2, 0, 0})};
    target.positions.setConstant(0.5);
    EXPECT_EQ(scene.robot.move_hand(target, 0.2, seconds), MotionEnd::reached);
    EXPECT_EQ(scene.robot.command().positions, target.positions);
    EXPECT_LT((scene.robot.reading().mount.xyz - target.mount.xyz).norm(), 1e-12);
    EXPECT_NEAR(scene.robot.time(), std::max(1.0, seconds), 0.2)
        << "the slower of both sets the pace";
    EXPECT_EQ(scene.robot.limited_commands(), 0);
  }
}

/// A hand with a clock of its own, which goes on while the program thinks.
TEST(Executor, APauseToThinkIsNoFaultOfTheClock) {
  for (const bool thinks : {true, false}) {
    double ahead = 0;
    hand::FakeHand fake([&](hand::HandReading& reading) { reading.time += ahead; });
    Executor robot(fake, hand::shadow_hand(), hand::resting_command());
    robot.wait(0.1);
    if (thinks) std::this_thread::sleep_for(std::chrono::milliseconds(500));
    ahead = 0.5;
    if (thinks) {
      EXPECT_NO_THROW(robot.wait(0.1));
    } else {
      EXPECT_THROW(robot.wait(0.1), SafetyStop);
      EXPECT_EQ(robot.fault().fault, Fault::implausible_change);
    }
  }
}

/// As arms do, whose drivers give angles from -pi to pi.
TEST(Executor, AttitudesMayBeReadInOtherTurns) {
  hand::FakeHand hand([](hand::HandReading& reading) {
    reading.mount = hand::MountPosition::at(reading.mount.pose());
  });
  Executor robot(hand, hand::shadow_hand(), hand::resting_command());
  hand::MountPosition turned = robot.command().mount;
  turned.ypr.x() = 4.2;
  EXPECT_EQ(robot.move_mount(turned, 0.4), MotionEnd::reached);
  EXPECT_NEAR(robot.reading().mount.ypr.x(), 4.2, 1e-9);
  robot.make_safe(Fault::stop_requested, "");
  EXPECT_NEAR(robot.command().mount.ypr.x(), 4.2, 1e-9) << "the safe state turned the hand";
}

TEST(Executor, WhatPressesOnTheHandIsNotTakenForDrift) {
  double load = 1;
  hand::FakeHand hand([&](hand::HandReading& reading) { reading.mount_force.z() = load; });
  Executor robot(hand, hand::shadow_hand(), hand::resting_command());
  tare(robot);
  robot.wait(0.05);
  EXPECT_NEAR(robot.reading().mount_force.z(), 0, 1e-6);
  load = 20;
  tare(robot);
  robot.wait(0.05);
  EXPECT_NEAR(robot.reading().mount_force.z(), 19, 1e-6);
}

TEST(Executor, APostureOfAnotherHandIsAFault) {
  Scene scene;
  const hand::HandCommand target{hand::ActuatorVector::Zero(3), at({0.1, 0, 0})};
  EXPECT_THROW(scene.robot.move_hand(target, 0.2, 0.3), SafetyStop);
  EXPECT_EQ(scene.robot.fault().fault, Fault::invalid_command);
}

TEST(Executor, ReportsEveryTickAndEvent) {
  int ticks = 0;
  std::vector<estimation::TouchEvent> events;
  Scene scene({}, {[&](const HandReading&, const hand::HandCommand&) { ++ticks; },
                   [&](estimation::TouchEvent event) { events.push_back(event); },
                   {}});
  scene.robot.add_event(estimation::TouchEvent::height_probed);
  scene.robot.wait(0.2);
  scene.robot.add_event(estimation::TouchEvent::closed);
  EXPECT_EQ(ticks, 21);
  EXPECT_EQ(events, (std::vector<estimation::TouchEvent>{estimation::TouchEvent::height_probed,
                                                         estimation::TouchEvent::closed}));
  EXPECT_EQ(scene.robot.log().readings.size(), 21u);
  EXPECT_EQ(scene.robot.log().at(estimation::TouchEvent::height_probed), 0u);
  EXPECT_EQ(scene.robot.log().at(estimation::TouchEvent::closed), 20u);
}

TEST(Executor, GripClosesWhileTheMountMovesAndWithinItsTorque) {
  Scene scene;
  const auto& preshape = kSoftHand.postures.top;
  Grip grip{grasping::ClosingLaw(kSoftHand, 1.0, preshape.closed), preshape.contact_torque, {}};
  grip.active[static_cast<std::size_t>(hand::FingerName::first)] = true;
  scene.robot.set_grip(grip);
  scene.robot.move_mount(at({0, 0, 0.05}), 0.1);
  const auto& positions = scene.robot.command().positions;
  EXPECT_GT(positions[hand::shadow_hand().actuator("FFJ3")], 0.1);
  EXPECT_EQ(positions[hand::shadow_hand().actuator("MFJ3")], 0);
  const double before = positions[hand::shadow_hand().actuator("FFJ3")];
  scene.robot.set_grip(std::nullopt);
  scene.robot.wait(0.1);
  EXPECT_EQ(positions[hand::shadow_hand().actuator("FFJ3")], before);
}

/// A scene whose mount is pushed upwards with 2 N in the times [from, to).
Scene pushed(double from, double to) {
  return Scene([from, to](HandReading& reading) {
    if (reading.time >= from && reading.time < to) reading.mount_force.z() = 2;
  });
}

MotionEnd wait_for_load(Executor& robot, const Eigen::Vector3d& direction, double load) {
  return robot.wait(1.5, lasting_load(robot, direction, load));
}

TEST(LastingLoad, NeedsSeveralTicksOnEnd) {
  Scene knock = pushed(0.795, 0.815);
  EXPECT_EQ(wait_for_load(knock.robot, Eigen::Vector3d::UnitZ(), 1), MotionEnd::reached);
  Scene push = pushed(0.795, 10);
  EXPECT_EQ(wait_for_load(push.robot, Eigen::Vector3d::UnitZ(), 1), MotionEnd::stopped);
  EXPECT_NEAR(push.robot.time(), 0.82, 1e-9);  // on the third tick
}

TEST(LastingLoad, IgnoresTheLoadOfSettingOut) {
  Scene jerk = pushed(0, 0.4);
  EXPECT_EQ(wait_for_load(jerk.robot, Eigen::Vector3d::UnitZ(), 1), MotionEnd::reached);
  Scene push = pushed(0, 10);
  EXPECT_EQ(wait_for_load(push.robot, Eigen::Vector3d::UnitZ(), 1), MotionEnd::stopped);
  EXPECT_NEAR(push.robot.time(), 0.44, 0.011);
}

TEST(LastingLoad, CountsOnlyWhatPushesAlongItsDirection) {
  Scene scene = pushed(0, 10);
  EXPECT_EQ(wait_for_load(scene.robot, -Eigen::Vector3d::UnitZ(), 1), MotionEnd::reached);
  Scene weak = pushed(0, 10);
  EXPECT_EQ(wait_for_load(weak.robot, Eigen::Vector3d::UnitZ(), 2.5), MotionEnd::reached);
}

/// A scene whose mount is pushed downwards with 0.3 N by its motion, and by an obstacle that adds
/// `load` upwards from a time on.
Scene moving_against(double load, double from) {
  return Scene([load, from](HandReading& reading) {
    reading.mount_force.z() = -0.3 + (reading.time >= from ? load : 0.0);
  });
}

MotionEnd wait_for_rise(Executor& robot, double load) {
  return robot.wait(1.5, rising_load(robot, Eigen::Vector3d::UnitZ(), load));
}

TEST(RisingLoad, IsMeasuredFromThatOfSteadyMotion) {
  Scene obstacle = moving_against(0.2, 0.795);
  EXPECT_EQ(wait_for_rise(obstacle.robot, 0.15), MotionEnd::stopped);
  EXPECT_NEAR(obstacle.robot.time(), 0.82, 1e-9);  // on the third tick, although it is below zero
  Scene weak = moving_against(0.1, 0.795);
  EXPECT_EQ(wait_for_rise(weak.robot, 0.15), MotionEnd::reached);
}

TEST(RisingLoad, AnObstacleThatGivesWayDoesNotStop) {
  Scene relief = moving_against(-5, 0.795);
  EXPECT_EQ(wait_for_rise(relief.robot, 0.15), MotionEnd::reached);
}

TEST(RisingLoad, NothingStopsTheFirstHalfSecond) {
  Scene always = moving_against(5, 0);
  EXPECT_EQ(wait_for_rise(always.robot, 0.15), MotionEnd::reached);
}

TEST(EventLog, ForgetsWhatWasBeforeTheLastRelease) {
  estimation::EventLog log;
  EXPECT_TRUE(log.since_release().empty());
  EXPECT_FALSE(log.at(estimation::TouchEvent::height_probed));
  log.moments = {{estimation::TouchEvent::height_probed, 1},
                 {estimation::TouchEvent::closed, 2},
                 {estimation::TouchEvent::height_probed, 3}};
  EXPECT_EQ(log.at(estimation::TouchEvent::height_probed), 3u);
  EXPECT_EQ(log.since_release().size(), 3u);
  log.moments.push_back({estimation::TouchEvent::released, 4});
  EXPECT_TRUE(log.since_release().empty());
  EXPECT_FALSE(log.at(estimation::TouchEvent::closed));
  log.moments.push_back({estimation::TouchEvent::closed, 5});
  log.moments.push_back({estimation::TouchEvent::released, 6});
  log.moments.push_back({estimation::TouchEvent::held, 7});
  EXPECT_EQ(log.since_release().size(), 1u);
  EXPECT_EQ(log.at(estimation::TouchEvent::held), 7u);
  EXPECT_FALSE(log.at(estimation::TouchEvent::closed));
}

TEST(EventLog, AnOpenedHandStartsAgainButKnowsTheGraspBefore) {
  estimation::EventLog log;
  log.readings.resize(12);
  log.moments = {{estimation::TouchEvent::height_probed, 1},
                 {estimation::TouchEvent::touched, 2},
                 {estimation::TouchEvent::closed, 3},
                 {estimation::TouchEvent::placed, 5}};
  EXPECT_FALSE(log.before_opening());
  log.moments.push_back({estimation::TouchEvent::opened, 7});
  EXPECT_FALSE(log.at(estimation::TouchEvent::closed));
  EXPECT_EQ(log.since_release().size(), 5u);
  log.moments.push_back({estimation::TouchEvent::closed, 9});
  EXPECT_EQ(log.at(estimation::TouchEvent::closed), 9u);
  EXPECT_TRUE(log.all(estimation::TouchEvent::touched).empty());
  const auto before = log.before_opening();
  ASSERT_TRUE(before);
  EXPECT_EQ(before->readings.size(), 8u);
  EXPECT_EQ(before->at(estimation::TouchEvent::closed), 3u);
  EXPECT_EQ(before->at(estimation::TouchEvent::placed), 5u);
  EXPECT_FALSE(before->before_opening());
  log.moments.push_back({estimation::TouchEvent::released, 11});
  EXPECT_FALSE(log.before_opening());
}

/// A phase that waits, then says what it was given to say.
class WaitingPhase : public Phase {
 public:
  WaitingPhase(double seconds, bool ok) : seconds_(seconds), ok_(ok) {}
  std::string_view name() const override { return "waiting"; }
  double time_limit() const override { return 1.0; }
  PhaseEnd run(Executor& robot, PickState&) override {
    end = robot.wait(seconds_);
    return {ok_, "waited"};
  }
  MotionEnd end = MotionEnd::stopped;

 private:
  double seconds_;
  bool ok_;
};

PhaseReport report_of(WaitingPhase phase, Executor& robot) {
  PickState state;
  return run_phase(phase, robot, state);
}

TEST(RunPhase, ReportsSuccessAndFailure) {
  Scene scene;
  const auto good = report_of({0.3, true}, scene.robot);
  EXPECT_EQ(good.name, "waiting");
  EXPECT_EQ(good.outcome, "waited");
  EXPECT_EQ(good.status, PhaseStatus::ok);
  EXPECT_NEAR(good.robot_seconds, 0.3, 1e-9);
  EXPECT_EQ(report_of({0.3, false}, scene.robot).status, PhaseStatus::failed);
}

TEST(RunPhase, TimesOutAndTakesTheDeadlineAway) {
  Scene scene;
  const auto late = report_of({5.0, true}, scene.robot);
  EXPECT_EQ(late.status, PhaseStatus::timed_out);
  EXPECT_EQ(to_string(late.status), "timed out");
  EXPECT_NEAR(late.robot_seconds, 1.0, kTick);
  EXPECT_EQ(scene.robot.wait(2.0), MotionEnd::reached);
}

TEST(RunPhase, ReportsThePeakForceOfItsOwnTimeAndTheLastContacts) {
  const Eigen::Vector3d up = Eigen::Vector3d::UnitZ();
  Scene scene([&](HandReading& reading) {
    const double force = reading.time < 0.1 ? 9 : reading.time < 0.3 ? 4 : 0.5;
    reading.contacts[1] = {{Eigen::Vector3d::Zero(), up, -force * up}};
    reading.contacts[3] = {{Eigen::Vector3d::Zero(), up, -0.05 * up}};
  });
  scene.robot.wait(0.15);
  const auto report = report_of({0.5, true}, scene.robot);
  EXPECT_DOUBLE_EQ(report.peak_force, 4);
  EXPECT_EQ(report.contacts, 1);  // the other is too weak to count
  EXPECT_EQ(hand::count_contacts(scene.robot.reading(), 0.01), 2);
  EXPECT_DOUBLE_EQ(hand::tip_force(scene.robot.reading(), 1), 0.5);
  EXPECT_EQ(hand::tip_force(scene.robot.reading(), 0), 0);
}

}  // namespace
}  // namespace palpate::skills
