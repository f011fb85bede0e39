// SPDX-License-Identifier: Apache-2.0
#include "palpate/skills/release/set_down_phase.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "hand/fake_hand.hpp"
#include "palpate/hand/shadow.hpp"
#include "palpate/hand/tip_forces.hpp"
#include "skills/release/release_phase.hpp"

namespace palpate::skills {
namespace {

constexpr double kHeldWeight = 2.0;  // N
constexpr double kStiffness = 2000;  // N/m, of what is stood on
constexpr double kGround = 0.15;     // m of the mount when the object touches

/// What the mount carries of a hanging object over ground that is `ground` high.
void stand(hand::HandReading& reading, double ground) {
  const double depth = std::max(0.0, ground - reading.mount.xyz.z());
  reading.mount_force.z() = kHeldWeight - kStiffness * depth;
}

PlaceGoal goal_at(double height) {
  PlaceGoal goal;
  goal.mount.xyz << 0.1, 0.05, height;
  goal.above = goal.mount;
  goal.above.xyz.z() += 0.1;
  return goal;
}

/// A hand whose first knuckle alone is bent where it opens.
hand::Description opening_hand() {
  hand::Description model = hand::with_soft_actuators();
  model.postures.top.open.setZero();
  model.postures.top.open[model.actuator("FFJ3")] = 0.2;
  return model;
}

/// A place phase on a fake hand that waits over the goal.
struct Descent {
  Descent(hand::FakeHand::Script script, double wall, double expected = kGround)
      : hand(std::move(script)),
        robot(hand, model, over(expected)),
        phase({}, goal_at(expected), wall) {}
  static hand::HandCommand over(double expected) {
    hand::HandCommand command = hand::resting_command();
    command.mount = goal_at(expected).above;
    return command;
  }
  PhaseReport run() {
    PickState state;
    phase = SetDownPhase({}, goal_at(expected_), wall_);
    return run_phase(phase, robot, state);
  }
  hand::Description model = opening_hand();
  hand::FakeHand hand;
  Executor robot;
  SetDownPhase phase;
  double wall_ = 0, expected_ = kGround;
};

TEST(SetDownPhase, StopsAtTheTableAndReleases) {
  Descent descent([](auto& reading) { stand(reading, kGround); }, 0);
  const auto report = descent.run();
  EXPECT_EQ(report.status, PhaseStatus::ok) << report.outcome;
  EXPECT_TRUE(descent.phase.released());
  EXPECT_EQ(descent.phase.touchdown(), SetDownPhase::Touchdown::flat);
  EXPECT_TRUE(descent.robot.log().at(estimation::TouchEvent::placed));
  EXPECT_DOUBLE_EQ(descent.robot.command().positions[hand::shadow_hand().actuator("FFJ3")], 0.2);
  // No deeper than what the wanted press takes, and what three ticks of delay add.
  EXPECT_GT(descent.robot.command().mount.xyz.z(),
            kGround - (kHeldWeight + 1) / kStiffness - 0.0005);
  EXPECT_NEAR(descent.phase.T_world_object().translation().z(), kGround, 0.003);
}

TEST(OpenPhase, OpensWhereTheHandIsAndMarksWhenItStillHeld) {
  Descent descent(
      [](auto& reading) {
        if (reading.joints[hand::shadow_hand().joint("FFJ3")] > 0.3) {
          reading.contacts[1] = {{{0, 0, 0.02}, {0, 1, 0}, {0, -1, 0}}};
        }
      },
      0);
  hand::ActuatorVector closed = descent.robot.command().positions;
  closed[hand::shadow_hand().actuator("FFJ3")] = 0.6;
  descent.robot.move_fingers(closed, 0.1);
  const auto mount = descent.robot.command().mount;
  PickState state;
  OpenPhase open({});
  EXPECT_EQ(run_phase(open, descent.robot, state).status, PhaseStatus::ok);
  const auto& log = descent.robot.log();
  ASSERT_TRUE(log.at(estimation::TouchEvent::placed));
  EXPECT_GT(hand::tip_force(log.readings[*log.at(estimation::TouchEvent::placed)], 1), 0.9);
  EXPECT_EQ(descent.robot.command().mount.xyz, mount.xyz);
  EXPECT_DOUBLE_EQ(descent.robot.command().positions[hand::shadow_hand().actuator("FFJ3")], 0.2);
}

TEST(OpenPhase, FailsWhileTheObjectIsStillSensed) {
  Descent descent(
      [](auto& reading) {
        reading.contacts[1] = {{{0, 0, 0.02}, {0, 1, 0}, {0, -1, 0}}};
      },
      0);
  PickState state;
  OpenPhase open({});
  EXPECT_EQ(run_phase(open, descent.robot, state).status, PhaseStatus::failed);
}

TEST(SetDownPhase, FollowsTheTableWhereItIsLowerThanExpected) {
  Descent descent([](auto& reading) { stand(reading, kGround - 0.008); }, 0);
  EXPECT_EQ(descent.run().status, PhaseStatus::ok);
  EXPECT_LT(descent.robot.command().mount.xyz.z(), kGround - 0.007);
}

TEST(SetDownPhase, AnEarlyContactIsARefusal) {
  LowerOptions options;
  Descent descent([](auto& reading) { stand(reading, kGround + 0.02); }, 0);
  options.near = 0.03;
  PickState state;
  SetDownPhase phase(options, goal_at(kGround), 0);
  const auto report = run_phase(phase, descent.robot, state);
  EXPECT_EQ(report.status, PhaseStatus::failed);
  EXPECT_EQ(phase.touchdown(), SetDownPhase::Touchdown::early);
  EXPECT_FALSE(phase.released());
  EXPECT_NE(report.outcome.find("refused"), std::string::npos);
  EXPECT_FALSE(descent.robot.log().at(estimation::TouchEvent::placed));
}

/// What has slipped in the hand meets the table on the fast way down.
TEST(SetDownPhase, WhatMeetsTheTableMuchTooEarlyIsNeitherPressedNorLost) {
  for (const double early : {0.016, 0.02, 0.034}) {
    Descent descent([early](auto& reading) { stand(reading, kGround + early); }, 0);
    descent.run();
    EXPECT_EQ(descent.phase.touchdown(), SetDownPhase::Touchdown::early) << early;
    for (const auto& reading : descent.robot.log().readings) {
      EXPECT_GT(reading.mount_force.z(), -5) << early << " m early";
    }
  }
}

TEST(SetDownPhase, NothingSensedIsNoReasonToRelease) {
  Descent descent([](auto& reading) { stand(reading, 0); }, 0);
  const auto report = descent.run();
  EXPECT_EQ(report.status, PhaseStatus::failed);
  EXPECT_EQ(descent.phase.touchdown(), SetDownPhase::Touchdown::nothing);
  EXPECT_FALSE(descent.phase.released());
}

TEST(SetDownPhase, AnEmptyHandIsNoticed) {
  Descent descent([](auto& reading) { reading.mount_force.setZero(); }, 0);
  EXPECT_EQ(descent.run().status, PhaseStatus::failed);
  EXPECT_EQ(descent.phase.touchdown(), SetDownPhase::Touchdown::lost);
}

TEST(SetDownPhase, LooksForASlotBesideAFirstMiss) {
  constexpr double kWall = 0.006;
  const Eigen::Vector2d slot = goal_at(kGround).mount.xyz.head<2>() + Eigen::Vector2d(0.002, 0);
  const auto script = [&](hand::HandReading& reading) {
    const bool in = (reading.mount.xyz.head<2>() - slot).norm() < 0.001;
    stand(reading, in ? kGround : kGround + kWall);
  };
  Descent descent(script, kWall);
  descent.wall_ = kWall;
  const auto report = descent.run();
  EXPECT_EQ(report.status, PhaseStatus::ok) << report.outcome;
  EXPECT_NE(report.outcome.find("try 2"), std::string::npos) << report.outcome;
}

/// An object that sank by `sag` in the hand: that early it touches, over ground that is `ground`
/// high, and its weight pushes it back before all of it is borne.
void stand_sunk(hand::HandReading& reading, double ground, double sag) {
  const double depth = ground + sag - reading.mount.xyz.z();
  const double pushed_back = std::clamp(depth / sag, 0.0, 1.0);
  const double beyond = std::max(0.0, depth - sag);
  reading.mount_force.z() = kHeldWeight * (1 - pushed_back) - kStiffness * beyond;
}

TEST(SetDownPhase, AnObjectThatSankInTheHandIsInTheSlotAllTheSame) {
  constexpr double kWall = 0.006, kSag = 0.005;
  Descent descent([](auto& reading) { stand_sunk(reading, kGround, kSag); }, kWall);
  descent.wall_ = kWall;
  const auto report = descent.run();
  EXPECT_EQ(report.status, PhaseStatus::ok) << report.outcome;
  EXPECT_EQ(report.outcome.find("try"), std::string::npos) << report.outcome;
}

TEST(SetDownPhase, AnObjectThatSankStandsOnAWallAllTheSame) {
  constexpr double kWall = 0.006, kSag = 0.004;
  Descent descent([](auto& reading) { stand_sunk(reading, kGround + kWall, kSag); }, kWall);
  descent.wall_ = kWall;
  const auto report = descent.run();
  EXPECT_EQ(report.status, PhaseStatus::failed) << report.outcome;
  EXPECT_EQ(descent.phase.touchdown(), SetDownPhase::Touchdown::early);
  EXPECT_FALSE(descent.phase.released());
}

TEST(SetDownPhase, GivesUpASlotThatIsNowhere) {
  Descent descent([](auto& reading) { stand(reading, kGround + 0.006); }, 0.006);
  descent.wall_ = 0.006;
  const auto report = descent.run();
  EXPECT_EQ(report.status, PhaseStatus::failed);
  EXPECT_EQ(descent.phase.touchdown(), SetDownPhase::Touchdown::early);
}

}  // namespace
}  // namespace palpate::skills
