// SPDX-License-Identifier: Apache-2.0
#include "palpate/skills/explore/height_probe_phase.hpp"

#include <gtest/gtest.h>

#include <numbers>

#include "hand/fake_hand.hpp"
#include "palpate/evaluation/trial.hpp"
#include "palpate/simulation/world/world.hpp"
#include "palpate/skills/pick.hpp"
#include "palpate/skills/place/regrasp.hpp"
#include "skills/soft_shadow.hpp"

namespace palpate::skills {
namespace {

/// A hand over a table on which a block of some height stands around a place, or nothing.
struct OverABlock {
  OverABlock(double height, const Eigen::Vector2d& place, double half_width)
      : hand([=](hand::HandReading& reading) {
          const Eigen::Vector2d away = reading.mount.xyz.head<2>() + kLevelCenter - place;
          const bool over = away.cwiseAbs().maxCoeff() < half_width;
          if (over && estimation::lowest_of_hand(soft_shadow(), reading) < height)
            reading.mount_force.z() = -2;
        }),
        robot(hand, soft_shadow(), evaluation::waiting_command(soft_shadow())) {}
  /// Of the flat hand at yaw 0, from its mount.
  inline static const Eigen::Vector2d kLevelCenter{0.072, -0.005};

  hand::FakeHand hand;
  Executor robot;
  PickState state;
};

TEST(HeightProbePhase, MeasuresHowTallTheObjectIs) {
  for (const double height : {0.04, 0.08, 0.15}) {
    OverABlock scene(height, {0, 0}, 0.03);
    const auto end = HeightProbePhase({}).run(scene.robot, scene.state);
    ASSERT_TRUE(end.ok) << end.outcome;
    EXPECT_NEAR(scene.state.height, height, 0.003);  // some ticks of the way down
    EXPECT_TRUE(scene.robot.log().at(estimation::TouchEvent::height_probed));
    EXPECT_GT(estimation::lowest_of_hand(soft_shadow(), scene.robot.reading()), height + 0.05);
  }
}

/// m/s downwards in the ticks in which the lowest part is between two heights.
double greatest_speed(const Executor& robot, double low, double high) {
  double speed = 0;
  const auto& readings = robot.log().readings;
  for (std::size_t i = 1; i < readings.size(); ++i) {
    const double height = estimation::lowest_of_hand(soft_shadow(), readings[i]);
    if (height < low || height > high) continue;
    speed =
        std::max(speed, (readings[i - 1].mount.xyz.z() - readings[i].mount.xyz.z()) / hand::kTick);
  }
  return speed;
}

TEST(HeightProbePhase, ComesDownSlowlyWhereTheObjectMayBe) {
  const HeightProbeOptions options;
  for (const double tallest : {0.04, 0.10}) {
    OverABlock scene(0.04, {0, 0}, 0.03);
    ASSERT_TRUE(HeightProbePhase(options, tallest).run(scene.robot, scene.state).ok);
    EXPECT_NEAR(scene.state.height, 0.04, 0.003);
    EXPECT_LT(greatest_speed(scene.robot, 0, tallest), options.touch_speed + 0.001);
    EXPECT_NEAR(greatest_speed(scene.robot, tallest + 0.04, 0.18), options.speed, 0.001);
  }
}

TEST(HeightProbePhase, TravelsOverWhateverMayStandThere) {
  OverABlock scene(0.04, {0, 0}, 0.03);
  scene.state.clear_height = 0.31;
  scene.robot.move_mount({{0.3, 0, 0.3}, {0, 0, 0}}, 1.0);  // beside, and low
  const std::size_t first = scene.robot.log().readings.size();
  ASSERT_TRUE(HeightProbePhase({}).run(scene.robot, scene.state).ok);
  const auto& readings = scene.robot.log().readings;
  for (std::size_t i = first; i < readings.size(); ++i) {
    const Eigen::Vector2d way =
        readings[i].mount.xyz.head<2>() - readings[i - 1].mount.xyz.head<2>();
    if (way.norm() < 1e-5) continue;  // up or down
    EXPECT_GT(estimation::lowest_of_hand(soft_shadow(), readings[i]), 0.305);
  }
}

TEST(HeightProbePhase, LooksBesideWhereNothingStands) {
  OverABlock scene(0.08, {0, 0.1}, 0.05);
  const auto end = HeightProbePhase({}).run(scene.robot, scene.state);
  ASSERT_TRUE(end.ok) << end.outcome;
  EXPECT_LT((scene.state.place - Eigen::Vector2d(0, 0.1)).norm(), 1e-9);
}

TEST(HeightProbePhase, LooksBetweenThePlacesToo) {
  OverABlock scene(0.08, {-0.05, 0}, 0.02);
  const auto end = HeightProbePhase({}).run(scene.robot, scene.state);
  ASSERT_TRUE(end.ok) << end.outcome;
  EXPECT_LT((scene.state.place - Eigen::Vector2d(-0.05, 0)).norm(), 1e-9);
}

TEST(HeightProbePhase, LooksAtTheCornersAtLast) {
  OverABlock scene(0.08, {0.1, -0.1}, 0.04);
  const auto end = HeightProbePhase({}).run(scene.robot, scene.state);
  ASSERT_TRUE(end.ok) << end.outcome;
  EXPECT_LT((scene.state.place - Eigen::Vector2d(0.1, -0.1)).norm(), 1e-9);
}

TEST(HeightProbePhase, HasTheTimeToLookEverywhere) {
  OverABlock scene(0, {0, 0}, 0.5);
  HeightProbePhase phase({});
  const PhaseReport report = run_phase(phase, scene.robot, scene.state);
  EXPECT_EQ(report.status, PhaseStatus::failed) << report.robot_seconds << " s";
}

/// An arm that cannot bring the hand to yaws below 0.8 rad.
struct TurnedHand : hand::FakeHand {
  hand::PathFeasibility check_path(std::span<const hand::MountPosition> way) const override {
    hand::PathFeasibility answer;
    if (way.back().ypr.x() < 0.8) answer.obstacle = "the forearm";
    return answer;
  }
};

TEST(HeightProbePhase, TurnsTheHandWhereTheArmRequiresIt) {
  TurnedHand hand;
  hand::HandCommand start = evaluation::waiting_command(soft_shadow());
  start.mount.ypr.x() = 1.5;
  Executor robot(hand, soft_shadow(), start);
  PickState state;
  EXPECT_FALSE(HeightProbePhase({}).run(robot, state).ok) << "nothing stands there";
  EXPECT_NEAR(robot.command().mount.ypr.x(), std::numbers::pi / 3, 1e-9);
  EXPECT_EQ(state.yaw, 0);
}

TEST(HeightProbePhase, TheBareTableIsNotTouched) {
  OverABlock scene(0, {0, 0}, 0.5);
  const HeightProbeOptions options;
  EXPECT_FALSE(HeightProbePhase(options).run(scene.robot, scene.state).ok);
  EXPECT_FALSE(scene.robot.log().at(estimation::TouchEvent::height_probed));
  for (const auto& reading : scene.robot.log().readings) {
    EXPECT_GT(estimation::lowest_of_hand(soft_shadow(), reading), options.clearance - 0.002);
  }
}

const geometry::ObjectModel& box() {
  static const geometry::ObjectModel model(geometry::load_known_object("box"));
  return model;
}

TEST(Pick, OfNothingGivesUpAfterItsAttempts) {
  OverABlock scene(0, {0, 0}, 0.5);
  PickOptions options;
  options.attempts = 2;
  options.calibrate.touches = 0;
  int calls = 0;
  PhaseObserver observer;
  observer.on_picked = [&](const PickResult& result) { calls += !result.held; };
  const PickResult result = pick(scene.robot, box(), options, 1, observer);
  EXPECT_FALSE(result.held);
  EXPECT_EQ(result.attempts, 2);
  EXPECT_EQ(result.failed_phase, "height_probe");
  EXPECT_TRUE(result.estimate.posterior.modes.empty());
  EXPECT_EQ(calls, 1);
  std::vector<std::string> names;
  for (const auto& phase : result.phases) names.push_back(phase.name);
  EXPECT_EQ(names, (std::vector<std::string>{"height_probe", "release", "height_probe"}));
}

TEST(Regrasp, OfNothingEndsAfterTheFirstRound) {
  OverABlock scene(0, {0, 0}, 0.5);
  PickOptions options;
  options.attempts = 1;
  options.calibrate.touches = 0;
  const PlaceTarget target{.kind = PlaceTarget::Kind::spot, .xy = {0.1, 0.1}};
  const RegraspResult result =
      regrasp(scene.robot, {.object = box(), .target = target, .pick = options, .seed = 1});
  EXPECT_EQ(result.status, RegraspStatus::not_held);
  ASSERT_EQ(result.rounds.size(), 1u);
  EXPECT_FALSE(result.rounds.front().place);
  EXPECT_EQ(to_string(result.status), "not_held");
}

}  // namespace
}  // namespace palpate::skills
