// SPDX-License-Identifier: Apache-2.0
#include "skills/release/release_phase.hpp"

#include <gtest/gtest.h>

#include "hand/fake_hand.hpp"
#include "palpate/hand/shadow.hpp"
#include "palpate/simulation/world/world.hpp"
#include "skills/soft_shadow.hpp"

namespace palpate::skills {
namespace {

/// A closed hand, up in the air, that has closed below.
struct Holding {
  explicit Holding(hand::FakeHand::Script script = {})
      : hand(std::move(script)), robot(hand, soft_shadow(), closed_command()) {
    robot.add_event(estimation::TouchEvent::closed);
    hand::MountPosition up = robot.command().mount;
    up.xyz.z() += 0.1;
    robot.move_mount(up, 0.5);
  }
  static hand::HandCommand closed_command() {
    hand::HandCommand command = hand::resting_command();
    command.mount.xyz = {0.02, -0.01, kHeight};
    command.positions.setConstant(0.8);
    return command;
  }
  static constexpr double kHeight = 0.15;  // m

  hand::FakeHand hand;
  Executor robot;
  PickState state;
};

/// What hangs in the hand weighs 2 N.
void bear_weight(hand::HandReading& reading) { reading.mount_force.z() += 2; }

TEST(ReleasePhase, AnEmptyHandDoesNotGoDown) {
  Holding holding;
  const double height = holding.robot.command().mount.xyz.z();
  const std::size_t before = holding.robot.log().readings.size();
  ASSERT_TRUE(ReleasePhase().run(holding.robot, holding.state).ok);
  for (std::size_t i = before; i < holding.robot.log().readings.size(); ++i) {
    EXPECT_GT(holding.robot.log().readings[i].mount.xyz.z(), height - 0.001);
  }
}

TEST(ReleasePhase, GivesWayWhereTheOpeningFingersPushItOff) {
  bool pushed = false;
  Holding holding([&](hand::HandReading& reading) {
    if (pushed) reading.mount_force.z() -= 15;
  });
  const double height = holding.robot.command().mount.xyz.z();
  pushed = true;
  ASSERT_TRUE(ReleasePhase().run(holding.robot, holding.state).ok);
  double opened_at = 0;  // where the last finger was still bent
  for (const auto& reading : holding.robot.log().readings) {
    if (reading.joints[hand::shadow_hand().joint("FFJ3")] > 0.2) opened_at = reading.mount.xyz.z();
  }
  EXPECT_GT(opened_at, height + 0.03);
}

TEST(ReleasePhase, GivesWayToAFingertipThatPushes) {
  bool pushed = false;
  Holding holding([&](hand::HandReading& reading) {
    if (pushed) reading.contacts[0].push_back({{0, 0, 0.02}, {0, 1, 0}, {0, -5, 0}});
  });
  const double height = holding.robot.command().mount.xyz.z();
  pushed = true;
  ASSERT_TRUE(ReleasePhase().run(holding.robot, holding.state).ok);
  double bent_at = 0;
  for (const auto& reading : holding.robot.log().readings) {
    if (reading.joints[hand::shadow_hand().joint("FFJ3")] > 0.2) bent_at = reading.mount.xyz.z();
  }
  EXPECT_GT(bent_at, height + 0.03);
}

TEST(ReleasePhase, TheThumbStaysOpposedUntilTheHandHasRisen) {
  Holding holding;
  ASSERT_TRUE(ReleasePhase().run(holding.robot, holding.state).ok);
  for (const auto& reading : holding.robot.log().readings) {
    if (reading.mount.xyz.z() > 0.33) continue;
    EXPECT_GT(reading.joints[hand::shadow_hand().joint("THJ4")], 0.79);
  }
  EXPECT_LE(holding.robot.command().positions[hand::shadow_hand().actuator("THJ4")], 0.1);
}

TEST(ReleasePhase, ReleasesWhereTheHandHadClosedAndGoesAway) {
  Holding holding(bear_weight);
  ASSERT_TRUE(ReleasePhase().run(holding.robot, holding.state).ok);
  // The fingers open no higher than they had closed: what hangs in them does not fall.
  double opened_at = 1;
  for (const auto& reading : holding.robot.log().readings) {
    if (reading.joints[hand::shadow_hand().joint("FFJ3")] > 0.79) opened_at = reading.mount.xyz.z();
  }
  EXPECT_NEAR(opened_at, Holding::kHeight, 1e-9);
  for (int i = 0; i < hand::kShadowActuators; ++i) {
    if (soft_shadow().actuators[static_cast<std::size_t>(i)].finger < 0) continue;
    EXPECT_LE(holding.robot.command().positions[i], 0.1);
  }
  EXPECT_GT(holding.robot.command().mount.xyz.z(), Holding::kHeight + 0.1);
  // What was sensed before no longer holds.
  EXPECT_FALSE(holding.robot.log().at(estimation::TouchEvent::closed));
}

TEST(ReleasePhase, TheNextTryIsWhereTheFingersLastTouched) {
  bool touching = true;
  Holding holding([&](hand::HandReading& reading) {
    if (!touching) return;
    for (auto& tip : reading.contacts) tip.push_back({{0, 0, 0.02}, {0, 1, 0}, {0, -1, 0}});
  });
  const auto T_mount_link = hand::forward_kinematics(soft_shadow(), holding.robot.reading().joints);
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (const auto& finger : soft_shadow().fingers) {
    mean += T_mount_link[static_cast<std::size_t>(finger.link)] * Eigen::Vector3d(0, 0, 0.02) / 5;
  }
  const Eigen::Vector2d expected = (holding.robot.reading().mount.pose() * mean).head<2>();
  touching = false;
  holding.robot.wait(0.1);
  ASSERT_TRUE(ReleasePhase().run(holding.robot, holding.state).ok);
  constexpr double kReach = 0.4;  // m: farther from the origin the object cannot be
  EXPECT_LT((holding.state.place - expected.cwiseMax(-kReach).cwiseMin(kReach)).norm(), 1e-9);
}

TEST(ClearPhase, RisesBeforeItOpensAndTurnsLevel) {
  Holding holding;
  hand::MountPosition turned = holding.robot.command().mount;
  turned.ypr = {0.4, 1.2, -0.8};
  holding.robot.move_mount(turned, 0.5);
  const std::size_t before = holding.robot.log().readings.size();
  ASSERT_TRUE(ClearPhase().run(holding.robot, holding.state).ok);
  for (std::size_t i = before; i < holding.robot.log().readings.size(); ++i) {
    const auto& reading = holding.robot.log().readings[i];
    if (reading.mount.xyz.z() > 0.33) continue;
    EXPECT_EQ(reading.mount.ypr, turned.ypr);
    EXPECT_GT(reading.joints[hand::shadow_hand().joint("FFJ3")], 0.79);
  }
  EXPECT_EQ(holding.robot.command().mount.ypr, Eigen::Vector3d::Zero());
  EXPECT_FALSE(holding.robot.log().at(
      estimation::TouchEvent::closed));  // what was sensed before no longer holds
}

TEST(ReleasePhase, DoesNotGoDownFromAbove) {
  Holding holding;
  hand::MountPosition high = holding.robot.command().mount;
  high.xyz.z() = 0.5;
  holding.robot.move_mount(high, 0.5);
  ASSERT_TRUE(ReleasePhase().run(holding.robot, holding.state).ok);
  EXPECT_EQ(holding.robot.command().mount.xyz.z(), 0.5);
}

}  // namespace
}  // namespace palpate::skills
