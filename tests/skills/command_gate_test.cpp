// SPDX-License-Identifier: Apache-2.0
#include "skills/safety/command_gate.hpp"

#include <gtest/gtest.h>

#include <limits>

#include "hand/descriptions.hpp"
#include "palpate/core/error.hpp"
#include "palpate/core/random.hpp"

namespace palpate::skills {
namespace {

using hand::kTick;

const hand::Description kSoftHand = hand::with_soft_actuators();

CommandGate gate(const SafetyOptions& options = {}) {
  return {kSoftHand.actuators, hand::resting_command(), options};
}

TEST(SpeedProfile, KeepsSpeedAndAccelerationFromRestToRest) {
  RandomStream random(1);
  for (int i = 0; i < 200; ++i) {
    const double way = random.uniform(0.0005, 0.5), speed = random.uniform(0.02, 2);
    SpeedProfile profile(way / speed);
    profile.limit(way, 0.6, 10);
    EXPECT_DOUBLE_EQ(profile.share(0), 0);
    EXPECT_DOUBLE_EQ(profile.share(profile.ticks()), 1);
    double before = 0;
    for (int tick = 1; tick <= profile.ticks() + 1; ++tick) {
      const double now = tick > profile.ticks()
                             ? 0
                             : way * (profile.share(tick) - profile.share(tick - 1)) / kTick;
      EXPECT_GE(now, 0);
      EXPECT_LT(now, 0.6 * (1 + 1e-9));
      EXPECT_LT(std::abs(now - before), 10 * kTick * (1 + 1e-9));
      before = now;
    }
  }
}

TEST(SpeedProfile, SlowMotionIsSteadyFromTheFirstTick) {
  SpeedProfile profile(0.5 / 0.05);
  profile.limit(0.5, 0.6, 10);
  EXPECT_EQ(profile.ticks(), 1000);
  EXPECT_DOUBLE_EQ(profile.share(1), 0.001);
  EXPECT_DOUBLE_EQ(profile.share(999), 0.999);
}

TEST(CommandGate, LimitsWhatIsTooFastAndCountsIt) {
  CommandGate limits = gate();
  hand::HandCommand far = hand::resting_command();
  far.mount.xyz = {1, 0, 0};
  far.mount.ypr = {0, 2, 0};
  far.positions.setConstant(1);
  hand::HandCommand before = hand::resting_command();
  double slide = 0, turn = 0, bend = 0;
  for (int tick = 0; tick < 400; ++tick) {
    const hand::HandCommand now = limits.limited(far);
    slide = std::max(slide, (now.mount.xyz - before.mount.xyz).norm() / kTick);
    turn = std::max(turn, (now.mount.ypr - before.mount.ypr).norm() / kTick);
    bend = std::max(bend, (now.positions - before.positions).cwiseAbs().maxCoeff() / kTick);
    before = now;
  }
  const SafetyOptions options;
  EXPECT_NEAR(slide, options.mount_speed, 1e-6);
  EXPECT_NEAR(turn, options.turn_speed, 1e-6);
  EXPECT_NEAR(bend, options.finger_speed, 1e-6);
  EXPECT_EQ(before.mount.xyz, far.mount.xyz);
  EXPECT_EQ(before.positions, far.positions);
  EXPECT_GT(limits.changed(), 100u);
}

TEST(CommandGate, LetsThroughWhatIsWithinTheLimits) {
  CommandGate limits = gate();
  hand::HandCommand command = hand::resting_command();
  for (int tick = 0; tick < 100; ++tick) {
    command.mount.xyz.x() += 0.05 * kTick;
    command.positions.array() += 1.0 * kTick;
    EXPECT_EQ(limits.limited(command).mount.xyz, command.mount.xyz);
  }
  EXPECT_EQ(limits.limited(command).positions, command.positions);  // to stop is allowed at once
  EXPECT_EQ(limits.changed(), 0u);
}

TEST(CommandGate, KeepsToRangesAndWorkspace) {
  SafetyOptions options;
  options.workspace = 0.2;
  CommandGate limits = gate(options);
  hand::HandCommand beyond = hand::resting_command();
  beyond.mount.xyz = {0, 3, 0};
  beyond.positions.setConstant(9);
  hand::HandCommand commanded;
  for (int tick = 0; tick < 400; ++tick) commanded = limits.limited(beyond);
  EXPECT_NEAR(commanded.mount.xyz.norm(), 0.2, 1e-9);
  EXPECT_EQ(commanded.positions.maxCoeff(), kSoftHand.actuators[0].command.high);
}

TEST(CommandGate, RefusesWhatIsNotFinite) {
  CommandGate limits = gate();
  hand::HandCommand bad = hand::resting_command();
  bad.positions[3] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(static_cast<void>(limits.limited(bad)), BadInput);
}

TEST(CommandGate, RefusesACommandOfAnotherHandsSize) {
  CommandGate limits = gate();
  for (const int size : {0, hand::kShadowActuators + 1}) {
    const hand::HandCommand bad{hand::ActuatorVector::Zero(size), {}};
    EXPECT_THROW(static_cast<void>(limits.limited(bad)), BadInput) << size;
  }
}

TEST(CommandGate, AMountThatTurnsBackStartsFromRest) {
  CommandGate limits = gate();
  hand::HandCommand command = hand::resting_command();
  double speed = 0;
  for (int tick = 0; tick < 50; ++tick) {
    speed = std::min(0.59, speed + 0.1);
    command.mount.xyz.x() += speed * kTick;
    command = limits.limited(command);
  }
  ASSERT_EQ(limits.changed(), 0u);
  hand::HandCommand back = command;
  back.mount.xyz.x() -= 0.59 * kTick;
  const double now = (limits.limited(back).mount.xyz.x() - command.mount.xyz.x()) / kTick;
  EXPECT_NEAR(now, -SafetyOptions{}.mount_acceleration * kTick, 1e-6);
  EXPECT_EQ(limits.changed(), 1u);
}

}  // namespace
}  // namespace palpate::skills
