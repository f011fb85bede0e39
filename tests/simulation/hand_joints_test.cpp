// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <string>

#include "palpate/hand/kinematics.hpp"
#include "palpate/hand/shadow.hpp"
#include "palpate/simulation/world/world.hpp"
#include "simulation/scenes.hpp"

namespace palpate::simulation {
namespace {

constexpr double kLimitGive = 0.03;  // rad, by which the pair's soft limit gives way at full load

struct Pair {
  double j1, j2;
};

Pair pair_of(const hand::JointVector& joints, const std::string& finger) {
  return {joints[hand::shadow_hand().joint(finger + "J1")],
          joints[hand::shadow_hand().joint(finger + "J2")]};
}

void command_j0(hand::HandCommand& command, double value) {
  for (const char* name : {"FFJ0", "MFJ0", "RFJ0", "LFJ0"}) {
    command.positions[hand::shadow_hand().actuator(name)] = value;
  }
}

/// Flexes J0 of all fingers from `from` to `to` at `rate` (rad/s), calling check after every tick.
template <class Check>
void flex(World& world, hand::HandCommand& command, double from, double to, double rate,
          Check check) {
  const int ticks = static_cast<int>(std::abs(to - from) / (rate * hand::kTick));
  for (int tick = 1; tick <= ticks; ++tick) {
    command_j0(command, from + (to - from) * tick / ticks);
    world.hand().step(command);
    check(world.truth().joints);
  }
}

TEST(HandJoints, DistalFollowsMiddleInFreeFlexion) {
  for (const double rate : {0.3, 2.0}) {
    World world(block(), without_noise(), 1);
    hand::HandCommand command = open_hand(0.5);
    world.reset({}, command);
    bool middle_alone = false;
    const auto check = [&](const hand::JointVector& joints) {
      for (const std::string finger : {"FF", "MF", "RF", "LF"}) {
        const auto [j1, j2] = pair_of(joints, finger);
        EXPECT_LE(j1, j2 + 0.005) << finger;
        middle_alone = middle_alone || (j2 > 0.3 && j1 < 0.1);
      }
    };
    flex(world, command, 0, 3.0, rate, check);
    EXPECT_TRUE(middle_alone);
    const auto [j1, j2] = pair_of(world.truth().joints, "FF");
    EXPECT_GT(j2, 1.4);
    EXPECT_GT(j1, 1.2);
    flex(world, command, 3.0, 0, rate, check);
  }
}

TEST(HandJoints, SlowFreeFlexionSharesAsCommanded) {
  World world(block(), without_noise(), 1);
  hand::HandCommand command = open_hand(0.5);
  world.reset({}, command);
  for (const double target : {0.25, 0.8, 1.6, 2.4}) {
    flex(world, command, target - 0.25, target, 0.25, [](const auto&) {});
    for (int tick = 0; tick < 100; ++tick) world.hand().step(command);
    const auto [j1, j2] = pair_of(world.truth().joints, "MF");
    const hand::CoupledAngles shared = hand::share_in_free_flexion(j1 + j2, {});
    EXPECT_NEAR(j2, shared.j2, 0.08) << "at J0 = " << j1 + j2;  // what friction leaves open
  }
}

TEST(HandJoints, AtRestAfterResetThePairStaysWhereItIs) {
  World world(block(), without_noise(), 1);
  hand::HandCommand command = open_hand(0.5);
  command_j0(command, 1.2);
  world.reset({}, command);
  const hand::JointVector before = world.truth().joints;
  for (int tick = 0; tick < 100; ++tick) world.hand().step(command);
  EXPECT_LT((world.truth().joints - before).cwiseAbs().maxCoeff(), 0.08);
}

/// Presses bent fingers on the block, then moves their J0 by `lead` and lets them press on.
hand::HandReading press_with_bent_fingers(World& world, double j0, double lead) {
  hand::HandCommand command = fingers_down(0.12);
  command_j0(command, j0);
  world.reset({}, command);
  hand::HandReading reading;
  for (int tick = 0; tick < 150; ++tick) {
    command.mount.xyz.z() = std::max(0.085, 0.12 - tick * 0.0005);
    reading = world.hand().step(command);
  }
  for (int tick = 0; tick < 150; ++tick) {
    command_j0(command, j0 + lead * std::min(1.0, tick / 100.0));
    reading = world.hand().step(command);
  }
  return reading;
}

TEST(HandJoints, DistalNeverExceedsMiddleInContact) {
  World world(block(), without_noise(), 1);
  int touching = 0;
  for (const double lead : {-0.5, 0.0, 0.5, 1.5}) {
    const hand::HandReading reading = press_with_bent_fingers(world, 0.6, lead);
    for (const auto& contacts : reading.contacts) touching += contacts.empty() ? 0 : 1;
    for (const std::string finger : {"FF", "MF", "RF", "LF"}) {
      const auto [j1, j2] = pair_of(world.truth().joints, finger);
      EXPECT_LE(j1, j2 + kLimitGive) << finger << " at lead " << lead;
    }
  }
  EXPECT_GE(touching, 4);
}

TEST(HandJoints, RangesAreThoseOfTableA1) {
  World world(block(), without_noise(), 1);
  const hand::Description& hand = world.hand_model();
  for (int actuator = 0; actuator < hand::kShadowActuators; ++actuator) {
    const auto i = static_cast<std::size_t>(actuator);
    const std::string name(hand::kShadowActuatorNames[i]);
    const hand::Range range = hand.actuators[i].command;
    const bool pair = name.back() == '0';
    const auto joint =
        static_cast<std::size_t>(hand::shadow_hand().joint(pair ? name.substr(0, 3) + "1" : name));
    const hand::Range of_joint = hand::shadow_hand().joints[joint].range;
    EXPECT_DOUBLE_EQ(range.low, of_joint.low) << name;
    EXPECT_DOUBLE_EQ(range.high, (pair ? 2 : 1) * of_joint.high) << name;
  }
}

TEST(HandJoints, JointsStopAtTheirRanges) {
  World world(block(), without_noise(), 1);
  for (const double side : {-10.0, 10.0}) {
    hand::HandCommand command = open_hand(0.5);
    world.reset({}, command);
    command.positions[hand::shadow_hand().actuator("WRJ2")] = side;
    command.positions[hand::shadow_hand().actuator("THJ4")] = side;
    for (int tick = 0; tick < 200; ++tick) world.hand().step(command);
    for (const char* name : {"WRJ2", "THJ4"}) {
      const auto index = hand::shadow_hand().joint(name);
      const hand::Range range = hand::shadow_hand().joints[static_cast<std::size_t>(index)].range;
      EXPECT_NEAR(world.truth().joints[index], side < 0 ? range.low : range.high, 0.02) << name;
    }
  }
}

}  // namespace
}  // namespace palpate::simulation
