// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>
#include <stdexcept>
#include <vector>

#include "hand/fake_hand.hpp"
#include "palpate/geometry/objects/known_object.hpp"
#include "palpate/skills/executor.hpp"
#include "palpate/skills/pick.hpp"
#include "skills/soft_shadow.hpp"

namespace palpate::skills {
namespace {

/// Remembers what it was commanded.
struct RecordingHand : hand::FakeHand {
  using FakeHand::FakeHand;
  hand::HandReading step(const hand::HandCommand& command) override {
    commands.push_back(command);
    return FakeHand::step(command);
  }
  std::vector<hand::HandCommand> commands;
};

TEST(Motion, ASpeedThatIsNoneIsAFaultAndMovesNothing) {
  for (const double speed : {0.0, -0.1, 1e-12, std::numeric_limits<double>::quiet_NaN(),
                             std::numeric_limits<double>::infinity()}) {
    for (const bool with_fingers : {false, true}) {
      RecordingHand hand;
      Executor robot(hand, hand::with_soft_actuators(), hand::resting_command());
      hand::HandCommand target = robot.command();
      target.mount.xyz.x() = 0.2;
      EXPECT_THROW(with_fingers ? robot.move_hand(target, speed, 0.5)
                                : robot.move_mount(target.mount, speed),
                   SafetyStop)
          << speed;
      EXPECT_EQ(robot.fault().fault, Fault::invalid_command);
      EXPECT_EQ(hand.commands.back().mount.xyz.x(), 0);
    }
  }
}

/// m/s^2 and rad/s^2, the largest of a motion of the mount by 0.1 m and 1 rad.
struct Accelerations {
  double way = 0, turn = 0;
};

Accelerations accelerations_of_motions(RecordingHand& hand, Executor& robot) {
  const std::size_t start = hand.commands.size();
  hand::HandCommand target = robot.command();
  target.mount.xyz.z() += 0.1;
  robot.move_mount(target.mount, 0.3);
  target.mount.ypr.x() += 1;
  robot.move_hand(target, 0.3, 0.1);
  Accelerations largest;
  for (std::size_t i = start + 2; i < hand.commands.size(); ++i) {
    const auto change = [&](const auto& of) {
      const double second = of(i) - 2 * of(i - 1) + of(i - 2);
      return std::abs(second) / (hand::kTick * hand::kTick);
    };
    const auto z = [&](std::size_t at) { return hand.commands[at].mount.xyz.z(); };
    const auto yaw = [&](std::size_t at) { return hand.commands[at].mount.ypr.x(); };
    largest.way = std::max(largest.way, change(z));
    largest.turn = std::max(largest.turn, change(yaw));
  }
  return largest;
}

TEST(Motion, AnObjectInTheHandIsAcceleratedGently) {
  for (const auto end : {estimation::TouchEvent::released, estimation::TouchEvent::opened}) {
    RecordingHand hand;
    Executor robot(hand, hand::with_soft_actuators(), hand::resting_command());
    const Accelerations free = accelerations_of_motions(hand, robot);
    EXPECT_GT(free.way, 6);
    EXPECT_GT(free.turn, 20);
    robot.add_event(estimation::TouchEvent::closed);
    const Accelerations held = accelerations_of_motions(hand, robot);
    EXPECT_GT(held.way, 1);
    EXPECT_LT(held.way, 2.1);
    EXPECT_GT(held.turn, 4);
    EXPECT_LT(held.turn, 8.4);
    robot.add_event(end);
    EXPECT_GT(accelerations_of_motions(hand, robot).way, 6);
  }
}

/// Its arm is accelerated less than what is held.
struct SlowHand : RecordingHand {
  hand::MountLimits mount_limits() const override {
    return {.acceleration = 1, .turn_acceleration = 3};
  }
};

TEST(Motion, WhatIsHeldIsAcceleratedNoMoreThanTheArmMayBe) {
  SlowHand hand;
  Executor robot(hand, hand::with_soft_actuators(), hand::resting_command());
  robot.add_event(estimation::TouchEvent::closed);
  const Accelerations held = accelerations_of_motions(hand, robot);
  EXPECT_LT(held.way, 1.05);
  EXPECT_LT(held.turn, 3.15);
}

/// Its arm is guarded at no speed.
struct StandingHand : RecordingHand {
  hand::MountLimits mount_limits() const override { return {.guarded_speed = 0}; }
};

TEST(Motion, AGuardedSpeedOfZeroIsAFault) {
  StandingHand hand;
  Executor robot(hand, hand::with_soft_actuators(), hand::resting_command());
  hand::MountPosition target;
  target.xyz.z() = -0.2;
  const auto never = [](const hand::HandReading&) { return false; };
  EXPECT_THROW(robot.move_mount(target, 0.1, never), SafetyStop);
  EXPECT_EQ(robot.fault().fault, Fault::invalid_command);
}

/// Its driver computes what it answers, wrongly.
struct ConfusedHand : RecordingHand {
  hand::PathFeasibility check_path(std::span<const hand::MountPosition>) const override {
    hand::PathFeasibility feasible;
    feasible.stretch = stretch;
    return feasible;
  }
  hand::MountLimits mount_limits() const override { return {.acceleration = acceleration}; }
  double stretch = 1, acceleration = 3;
};

TEST(Motion, AnswersOfTheHandThatAreNoneAreFaults) {
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  const auto fault_with = [](double stretch, double acceleration) {
    ConfusedHand hand;
    hand.stretch = stretch;
    hand.acceleration = acceleration;
    Executor robot(hand, hand::with_soft_actuators(), hand::resting_command());
    hand::MountPosition target;
    target.xyz.z() = 0.2;
    try {
      EXPECT_EQ(robot.move_mount(target, 0.1), MotionEnd::reached);
      EXPECT_EQ(hand.commands.back().mount.xyz.z(), 0.2);
    } catch (const SafetyStop&) {
      EXPECT_EQ(hand.commands.back().mount.xyz.z(), 0);
    }
    return robot.fault().fault;
  };
  EXPECT_EQ(fault_with(1.5, 3), Fault::none);
  for (const double stretch : {kNan, kInfinity, 1e9}) {
    EXPECT_EQ(fault_with(stretch, 3), Fault::exception) << stretch;
  }
  for (const double acceleration : {kNan, 0.0, -1.0}) {
    EXPECT_EQ(fault_with(1, acceleration), Fault::exception) << acceleration;
  }
}

/// Cannot judge ways, or does not know its limits.
struct JudgingHand : RecordingHand {
  explicit JudgingHand(bool of_ways) : RecordingHand({}, soft_shadow()), ways(of_ways) {}
  hand::PathFeasibility check_path(std::span<const hand::MountPosition>) const override {
    if (ways) throw std::runtime_error("no map");
    return {};
  }
  hand::MountLimits mount_limits() const override {
    if (!ways) throw std::runtime_error("no limits");
    return {};
  }
  bool ways;
};

TEST(Motion, WhatTheHandThrowsInJudgingIsAFaultOfThePick) {
  const geometry::ObjectModel object(geometry::load_known_object("box"));
  for (const bool of_ways : {true, false}) {
    JudgingHand hand(of_ways);
    Executor robot(hand, soft_shadow(), hand::resting_command());
    const PickResult result = pick(robot, object, {}, 1);
    EXPECT_EQ(result.fault.fault, Fault::exception);
    EXPECT_EQ(result.fault.detail, of_ways ? "the hand: no map" : "the hand: no limits");
    for (const auto& command : hand.commands) EXPECT_EQ(command.mount.xyz.norm(), 0);
  }
}

}  // namespace
}  // namespace palpate::skills
