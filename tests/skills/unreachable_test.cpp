// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <utility>

#include "hand/fake_hand.hpp"
#include "palpate/skills/phase.hpp"
#include "skills/motion/stretched_way.hpp"

namespace palpate::skills {
namespace {

const hand::Description kSoftHand = hand::with_soft_actuators();

/// A hand whose mount is carried by what judges every path in the same way.
struct CarriedHand : hand::FakeHand {
  hand::PathFeasibility check_path(std::span<const hand::MountPosition>) const override {
    return answer;
  }
  hand::PathFeasibility answer;
};

struct SlowScene {
  CarriedHand hand;
  Executor robot{hand, kSoftHand, hand::resting_command()};
};

/// Commands that go 0.5 mm a tick along x, from where the robot is.
std::vector<hand::HandCommand> straight_way(const Executor& robot, int ticks) {
  std::vector<hand::HandCommand> way;
  for (int i = 1; i <= ticks; ++i) {
    way.push_back(robot.command());
    way.back().mount.xyz.x() += 5e-4 * i;
  }
  return way;
}

TEST(StretchedWay, KeepsToTheLinesBetweenTheCommands) {
  const hand::HandCommand from = hand::resting_command();
  std::vector<hand::HandCommand> way(4, from);
  for (int i = 0; i < 4; ++i) way[static_cast<std::size_t>(i)].mount.xyz.x() = i < 2 ? i + 1 : 2;
  for (int i = 2; i < 4; ++i) way[static_cast<std::size_t>(i)].mount.xyz.y() = i - 1;
  const auto same = stretched(from, way, 4);
  for (std::size_t i = 0; i < 4; ++i) EXPECT_EQ(same[i].mount.xyz, way[i].mount.xyz);
  const auto slow = stretched(from, way, 6);
  ASSERT_EQ(slow.size(), 6u);
  EXPECT_EQ(slow.back().mount.xyz, way.back().mount.xyz);
  Eigen::Vector3d before = from.mount.xyz;
  for (const auto& command : slow) {
    const Eigen::Vector3d step = command.mount.xyz - before;
    EXPECT_NEAR(step.cwiseAbs().sum(), 4.0 / 6, 1e-12);  // of 4 m on two sides of a corner
    before = command.mount.xyz;
  }
  EXPECT_TRUE(stretched(from, {}, 0).empty());
}

/// A hand whose mount cannot turn while it moves.
struct TurnsOrMoves : hand::FakeHand {
  hand::PathFeasibility check_path(std::span<const hand::MountPosition> way) const override {
    hand::PathFeasibility answer;
    for (std::size_t i = 1; i < way.size(); ++i) {
      const bool moves = (way[i].xyz - way[i - 1].xyz).norm() > 1e-12;
      const bool turns = (way[i].ypr - way[i - 1].ypr).norm() > 1e-12;
      if (moves && turns) answer.obstacle = "it would do both";
    }
    return answer;
  }
};

TEST(Executor, TurnsAtTheHigherEndWhereTheStraightWayIsObstructed) {
  for (const double rise : {0.1, -0.1}) {
    TurnsOrMoves hand;
    Executor robot(hand, kSoftHand, hand::resting_command());
    const hand::MountPosition from = robot.command().mount;
    hand::MountPosition target = from;
    target.xyz += Eigen::Vector3d(0.1, 0, rise);
    target.ypr.x() += 0.5;
    EXPECT_EQ(robot.move_mount(target, 0.2), MotionEnd::reached);
    EXPECT_EQ(robot.command().mount.xyz, target.xyz);
    EXPECT_EQ(robot.command().mount.ypr, target.ypr);
    const double higher = std::max(from.xyz.z(), target.xyz.z());
    for (const auto& reading : robot.log().readings) {
      const double turned = reading.mount.ypr.x() - from.ypr.x();
      if (turned < 1e-9 || turned > 0.5 - 1e-9) continue;
      EXPECT_NEAR(reading.mount.xyz.z(), higher, 1e-9);
    }
    const auto never = [](const hand::HandReading&) { return false; };
    EXPECT_THROW(robot.move_mount(from, 0.2, never), Unreachable) << "guarded: straight, or not";
  }
}

TEST(Executor, FollowsASlowArmsWayMoreSlowly) {
  for (const double stretch : {0.0, 1.0, 1.51}) {
    SlowScene scene;
    scene.hand.answer.stretch = stretch;
    const auto way = straight_way(scene.robot, 100);
    const std::size_t first = scene.robot.log().readings.size();
    EXPECT_EQ(scene.robot.follow(way), MotionEnd::reached);
    const auto& readings = scene.robot.log().readings;
    EXPECT_EQ(readings.size() - first, stretch > 1 ? 151u : 100u);
    EXPECT_EQ(readings.back().mount.xyz, way.back().mount.xyz);
    for (std::size_t i = first; i < readings.size(); ++i) {
      const double step = (readings[i].mount.xyz - readings[i - 1].mount.xyz).norm();
      EXPECT_LE(step, 5e-4 / std::max(1.0, stretch) * 1.001) << i;
    }
  }
}

class FollowingPhase : public Phase {
 public:
  std::string_view name() const override { return "following"; }
  double time_limit() const override { return 5; }
  PhaseEnd run(Executor& robot, PickState&) override {
    robot.follow(straight_way(robot, 10));
    return {true, "there"};
  }
};

TEST(Phase, SaysWhetherTheArmCouldNotTakeTheHandThere) {
  SlowScene scene;
  PickState state;
  FollowingPhase phase;
  EXPECT_FALSE(run_phase(phase, scene.robot, state).unreachable);
  scene.hand.answer.obstacle = "out of reach of the arm";
  const Eigen::Vector3d before = scene.robot.command().mount.xyz;
  const PhaseReport report = run_phase(phase, scene.robot, state);
  EXPECT_TRUE(report.unreachable);
  EXPECT_EQ(report.status, PhaseStatus::failed);
  EXPECT_EQ(report.outcome, "unreachable: out of reach of the arm");
  EXPECT_EQ(scene.robot.command().mount.xyz, before);
}

}  // namespace
}  // namespace palpate::skills
