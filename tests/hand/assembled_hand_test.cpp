// SPDX-License-Identifier: Apache-2.0
#include "palpate/hand/assembled_hand.hpp"

#include <gtest/gtest.h>

#include <chrono>
#include <functional>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "hand/fake_hand.hpp"
#include "palpate/core/error.hpp"

namespace palpate::hand {
namespace {

/// An arm that is at once where it is commanded to be.
struct PromptArm : Arm {
  std::string name() const override { return "lift"; }
  void move(const MountPosition& to) override {
    target = to;
    ++moves;
  }
  std::optional<ArmReading> read() override {
    ++reads;
    if (on_read) on_read();
    if (silent) return std::nullopt;
    return ArmReading{target, {0, 0, 3}};
  }
  PathFeasibility check_path(std::span<const MountPosition> way) const override {
    if (judge) judge();
    return {.obstacle = "the ceiling", .feasible = way.size() / 2};
  }
  MountLimits mount_limits() const override { return {.guarded_speed = 0.01}; }

  MountPosition target;
  bool silent = false;
  int moves = 0, reads = 0;
  std::function<void()> on_read, judge;
};

struct PromptSensor : Sensor {
  std::optional<std::vector<TipContact>> read() override { return sensed; }
  std::optional<std::vector<TipContact>> sensed = std::vector<TipContact>{};
};

TipContact contact_at(double x) {
  const Eigen::Vector3d up = Eigen::Vector3d::UnitZ();
  return {{x, 0, 0}, up, -up};
}

HandCommand command_at(double z) {
  HandCommand command = resting_command();
  command.mount.xyz.z() = z;
  return command;
}

/// Fingers that sense something at their first two tips and bear a load.
struct Parts {
  FakeHand fingers{[this](HandReading& reading) {
    ++steps;
    reading.contacts[0] = {contact_at(0.1)};
    reading.contacts[1] = {contact_at(0.2)};
    reading.mount.xyz.x() = 7;
  }};
  PromptArm arm;
  PromptSensor pad, tip;
  int steps = 0;
};

std::string failure_of(AssembledHand& hand, const HandCommand& command) {
  try {
    hand.step(command);
  } catch (const std::runtime_error& error) {
    return error.what();
  }
  return {};
}

TEST(AssembledHand, AnArmCarriesAndSensorsSense) {
  Parts parts;
  parts.pad.sensed = {contact_at(0.3)};
  parts.tip.sensed = {contact_at(0.4), contact_at(0.5)};
  AssembledHand hand(parts.fingers, &parts.arm, {{&parts.pad, 0, "pad"}, {&parts.tip, 0, "tip"}});
  const HandReading reading = hand.step(command_at(0.2));
  EXPECT_EQ(parts.arm.target.xyz.z(), 0.2);
  EXPECT_EQ(reading.mount.xyz, Eigen::Vector3d(0, 0, 0.2));
  EXPECT_EQ(reading.mount_force.z(), 3);
  EXPECT_EQ(reading.time, kTick);
  ASSERT_EQ(reading.contacts[0].size(), 3u);  // of both sensors, none of the fingers' own
  EXPECT_EQ(reading.contacts[0][0].p.x(), 0.3);
  EXPECT_EQ(reading.contacts[0][2].p.x(), 0.5);
  ASSERT_EQ(reading.contacts[1].size(), 1u);
  EXPECT_NEAR(reading.contacts[1][0].p.x(), 0.2, 1e-9);
  EXPECT_EQ(hand.mount_limits().guarded_speed, 0.01);
  const std::vector<MountPosition> way(6);
  EXPECT_EQ(hand.check_path(way).obstacle, "the ceiling");
  EXPECT_EQ(hand.check_path(way).feasible, 3u);
}

/// Fingers that can tell what they sense before they are commanded.
struct SensingFingers : FakeHand {
  std::optional<HandReading> sense() override {
    HandReading reading = resting_reading(shadow_hand());
    reading.time = 5;
    return reading;
  }
};

TEST(AssembledHand, AllPartsAreSensedBeforeTheFirstCommand) {
  Parts parts;
  SensingFingers fingers;
  parts.arm.target.xyz.x() = 0.7;
  parts.arm.silent = true;
  parts.arm.on_read = [&] { parts.arm.silent = parts.arm.reads < 3; };
  parts.tip.sensed = {contact_at(0.4)};
  AssembledHand hand(fingers, &parts.arm, {{&parts.tip, 1, "tip"}});
  const auto sensed = hand.sense();
  ASSERT_TRUE(sensed);
  EXPECT_EQ(sensed->time, 5);
  EXPECT_EQ(sensed->mount.xyz.x(), 0.7);
  EXPECT_EQ(sensed->contacts[1].size(), 1u);
  EXPECT_EQ(parts.arm.moves, 0);
  EXPECT_EQ(parts.arm.reads, 3);
}

TEST(AssembledHand, FingersThatCannotTellBeforeAreNotSensed) {
  Parts parts;
  AssembledHand hand(parts.fingers, &parts.arm, {});
  EXPECT_FALSE(hand.sense());
  EXPECT_EQ(parts.arm.moves + parts.arm.reads + parts.steps, 0);
}

TEST(AssembledHand, AnArmThatIsNotHeardIsNamedBeforeItIsCommanded) {
  Parts parts;
  SensingFingers fingers;
  parts.arm.silent = true;
  AssembledHand hand(fingers, &parts.arm, {});
  EXPECT_THROW(hand.sense(), LateAnswer);
  EXPECT_EQ(parts.arm.moves, 0);
}

TEST(AssembledHand, WithoutPartsItIsTheFingers) {
  Parts parts;
  AssembledHand hand(parts.fingers, nullptr, {});
  const HandReading reading = hand.step(command_at(0.2));
  EXPECT_EQ(reading.mount.xyz.x(), 7);
  EXPECT_EQ(reading.contacts[0].size(), 1u);
  EXPECT_TRUE(hand.check_path({}).obstacle.empty());
}

TEST(AssembledHand, TheTimeStaysWhileAPartHasNothingNewer) {
  Parts parts;
  AssembledHand hand(parts.fingers, &parts.arm, {{&parts.pad, 0, "pad"}});
  const double first = hand.step(command_at(0)).time;
  const auto sensed = std::exchange(parts.pad.sensed, std::nullopt);
  EXPECT_EQ(hand.step(command_at(0)).time, first);
  parts.pad.sensed = sensed;
  EXPECT_EQ(hand.step(command_at(0)).time, first + 2 * kTick);
  parts.arm.silent = true;
  EXPECT_EQ(hand.step(command_at(1)).time, first + 2 * kTick);
  EXPECT_EQ(hand.step(command_at(1)).mount.xyz.z(), 0);  // where it was measured last
}

TEST(AssembledHand, ASilentPartIsNamed) {
  Parts parts;
  AssembledHand hand(parts.fingers, &parts.arm, {}, {.wait = 0, .gap = 0.05});
  hand.step(command_at(0));
  parts.arm.silent = true;
  for (int i = 0; i < 4; ++i) hand.step(command_at(0));
  EXPECT_THROW(
      {
        try {
          hand.step(command_at(0));
        } catch (const LateAnswer& late) {
          EXPECT_STREQ(late.what(), "the arm 'lift': no new reading for 0.05 s");
          throw;
        }
      },
      LateAnswer);
}

TEST(AssembledHand, AtFirstItWaitsForEveryPart) {
  Parts parts;
  parts.arm.silent = true;
  parts.arm.on_read = [&] { parts.arm.silent = parts.arm.reads < 4; };
  AssembledHand hand(parts.fingers, &parts.arm, {});
  EXPECT_EQ(hand.step(command_at(0.3)).mount.xyz.z(), 0.3);
  EXPECT_EQ(parts.steps, 4);

  Parts mute;
  mute.pad.sensed.reset();
  AssembledHand never(mute.fingers, nullptr, {{&mute.pad, 2, "pad"}});
  EXPECT_EQ(failure_of(never, command_at(0)), "the sensor 'pad': no new reading for 0.25 s");
}

TEST(AssembledHand, AnExceptionNamesItsPartAndTheOthersGoOn) {
  Parts parts;
  parts.arm.on_read = [] { throw std::runtime_error("no route to host"); };
  AssembledHand hand(parts.fingers, &parts.arm, {});
  EXPECT_EQ(failure_of(hand, command_at(0.1)), "the arm 'lift': no route to host");
  EXPECT_EQ(parts.steps, 1);
  EXPECT_EQ(failure_of(hand, command_at(0.2)), "");  // the robot is being stopped
  EXPECT_EQ(parts.steps, 2);
  EXPECT_EQ(parts.arm.target.xyz.z(), 0.2);
}

TEST(AssembledHand, WhateverIsThrownNamesItsPart) {
  Parts parts;
  parts.arm.on_read = [] { throw 7; };
  AssembledHand hand(parts.fingers, &parts.arm, {});
  EXPECT_EQ(failure_of(hand, command_at(0.1)), "the arm 'lift': an unknown exception");
  Parts others;
  others.arm.judge = [] { throw 7; };
  AssembledHand judged(others.fingers, &others.arm, {});
  judged.step(command_at(0));
  EXPECT_TRUE(judged.check_path({}).obstacle.empty());
  EXPECT_EQ(failure_of(judged, command_at(0)), "the arm 'lift': an unknown exception");
}

TEST(AssembledHand, ASensorOfNoFingerIsRefused) {
  Parts parts;
  EXPECT_THROW(AssembledHand(parts.fingers, nullptr, {{&parts.pad, -1, "pad"}}), BadInput);
  EXPECT_THROW(AssembledHand(parts.fingers, nullptr, {{nullptr, 0, "pad"}}), BadInput);
  AssembledHand hand(parts.fingers, nullptr, {{&parts.pad, 5, "pad"}});
  EXPECT_EQ(failure_of(hand, command_at(0)), "the sensor 'pad': on finger 5 of 5");
}

TEST(AssembledHand, APartThatTakesTooLongIsNamed) {
  Parts parts;
  parts.arm.on_read = [] { std::this_thread::sleep_for(std::chrono::milliseconds(600)); };
  AssembledHand patient(parts.fingers, &parts.arm, {});
  EXPECT_EQ(failure_of(patient, command_at(0)), "");
  AssembledHand hand(parts.fingers, &parts.arm, {}, {.wait = 0.5, .gap = 0.25});
  EXPECT_TRUE(failure_of(hand, command_at(0)).starts_with("the arm 'lift' took "));
}

TEST(AssembledHand, AFailureToJudgeMovesNothing) {
  Parts parts;
  AssembledHand hand(parts.fingers, &parts.arm, {});
  hand.step(command_at(0));
  parts.arm.judge = [] { throw std::runtime_error("no map"); };
  EXPECT_TRUE(hand.check_path({}).obstacle.empty());
  EXPECT_EQ(failure_of(hand, command_at(0.5)), "the arm 'lift': no map");
  EXPECT_EQ(parts.arm.moves, 1);
  EXPECT_EQ(parts.steps, 1);
}

/// Gives something newer every second tick, at even or odd ones.
struct SlowSensor : Sensor {
  explicit SlowSensor(int at) : phase(at) {}
  std::optional<std::vector<TipContact>> read() override {
    if (++reads % 2 != phase) return std::nullopt;
    return std::vector<TipContact>{contact_at(0.01 * reads)};
  }
  int phase, reads = 0;
};

TEST(AssembledHand, SensorsNeedNotBeInStep) {
  FakeHand fingers;
  SlowSensor even(0), odd(1);
  AssembledHand hand(fingers, nullptr, {{&even, 0, "even"}, {&odd, 1, "odd"}});
  double last = hand.step(command_at(0)).time;
  int advances = 0;
  for (int i = 0; i < 20; ++i) {
    const HandReading reading = hand.step(command_at(0));
    EXPECT_LE(reading.time - last, 2 * kTick + 1e-9);
    advances += reading.time > last;
    last = reading.time;
  }
  EXPECT_EQ(advances, 10);
}

}  // namespace
}  // namespace palpate::hand
