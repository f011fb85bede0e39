// SPDX-License-Identifier: Apache-2.0
#include "palpate/skills/place/transport_phase.hpp"

#include <gtest/gtest.h>

#include <optional>

#include "hand/arms.hpp"
#include "hand/fake_hand.hpp"
#include "palpate/core/assets.hpp"
#include "palpate/hand/arm_follower.hpp"
#include "palpate/simulation/collision/collision_scene.hpp"
#include "palpate/simulation/hand/load_hand.hpp"
#include "palpate/simulation/world/world.hpp"

namespace palpate::skills {
namespace {

constexpr double kWeight = 3.0;  // N

/// A hand on what takes so many times as long as wanted, and may not turn while it moves; or on an
/// arm.
struct CarriedHand : hand::FakeHand {
  using hand::FakeHand::FakeHand;
  hand::HandReading step(const hand::HandCommand& command) override {
    if (arm) arm->follow(command.mount.pose());
    return hand::FakeHand::step(command);
  }
  hand::PathFeasibility check_path(std::span<const hand::MountPosition> way) const override {
    if (arm) return arm->check_path(way);
    hand::PathFeasibility answer;
    answer.stretch = stretch;
    for (std::size_t i = 1; turns_or_moves && i < way.size(); ++i) {
      const bool moves = (way[i].xyz - way[i - 1].xyz).norm() > 1e-9;
      const bool turns = (way[i].ypr - way[i - 1].ypr).norm() > 1e-9;
      if (moves && turns) answer.obstacle = "it would do both";
    }
    return answer;
  }
  hand::ArmPosture arm_posture() const override {
    return arm && tells ? arm->posture() : hand::ArmPosture{};
  }
  double stretch = 1;
  bool turns_or_moves = false;
  bool tells = true;  // its arm
  std::optional<hand::ArmFollower> arm;
};

/// A hand that holds a box 25 cm below its mount, 30 cm over the table.
struct Carrying {
  explicit Carrying(hand::FakeHand::Script script)
      : hand([script = std::move(script)](hand::HandReading& reading) {
          reading.mount_force.z() = kWeight;
          for (auto& tip : reading.contacts) tip.push_back({{0, 0, 0.02}, {0, 1, 0}, {0, -1, 0}});
          if (script) script(reading);
        }),
        robot(hand, model, waiting()) {
    robot.wait(0.3);
    goal.T_mount_object.translation() << 0, 0, -0.25;
    goal.mount.xyz << 0.2, 0.1, 0.42;
    goal.mount.ypr << 0.8, 0, 0;
    goal.above = goal.mount;
    goal.above.xyz.z() += 0.1;
  }
  static hand::HandCommand waiting() {
    hand::HandCommand command = hand::resting_command();
    command.mount.xyz.z() = 0.6;
    return command;
  }
  PhaseReport run(const TransportOptions& options = {}) {
    TransportPhase phase(options, scene, goal, 1);
    PickState state;
    const auto report = run_phase(phase, robot, state);
    lost = phase.lost();
    motion = phase.motion();
    return report;
  }

  hand::Description model =
      hand::with_soft_actuators(simulation::load_shadow_hand(asset("shadow_hand/right_hand.xml")));
  CarriedHand hand;
  Executor robot;
  simulation::CollisionScene scene{geometry::load_known_object("box"), model};
  PlaceGoal goal;
  planning::Plan motion;
  bool lost = false;
};

TEST(TransportPhase, EndsOverTheGoalWithinItsLimits) {
  Carrying carrying({});
  const auto report = carrying.run();
  EXPECT_EQ(report.status, PhaseStatus::ok) << report.outcome;
  EXPECT_NE(report.outcome.find("at most 0.0 mm behind"), std::string::npos) << report.outcome;
  EXPECT_LT((carrying.robot.command().mount.xyz - carrying.goal.above.xyz).norm(), 1e-9);
  EXPECT_LT((carrying.robot.command().mount.ypr - carrying.goal.above.ypr).norm(), 1e-9);
  const auto& readings = carrying.robot.log().readings;
  const TransportOptions options;
  for (std::size_t i = 1; i < readings.size(); ++i) {
    const Eigen::Vector3d step = readings[i].mount.xyz - readings[i - 1].mount.xyz;
    EXPECT_LE(step.cwiseAbs().maxCoeff(),
              options.plan.limits.mount_speed * ::palpate::hand::kTick + 1e-9);
    // The fingers keep still.
    EXPECT_LT((readings[i].joints - readings[0].joints).cwiseAbs().maxCoeff(), 1e-9);
  }
}

TEST(TransportPhase, ASlowArmStretchesTheMotion) {
  Carrying fast({}), slow({});
  slow.hand.stretch = 1.5;
  const auto quick = fast.run(), report = slow.run();
  EXPECT_EQ(report.status, PhaseStatus::ok) << report.outcome;
  EXPECT_NE(report.outcome.find("at most 0.0 mm behind"), std::string::npos) << report.outcome;
  EXPECT_NEAR(report.robot_seconds - quick.robot_seconds, 0.5 * fast.motion.duration(), 0.02);
  EXPECT_LT((slow.robot.command().mount.xyz - slow.goal.above.xyz).norm(), 1e-9);
}

TEST(TransportPhase, TurnsBeforeItMovesWhereTheArmCannotDoBoth) {
  Carrying carrying({});
  carrying.hand.turns_or_moves = true;
  const auto report = carrying.run();
  EXPECT_EQ(report.status, PhaseStatus::ok) << report.outcome;
  EXPECT_LT((carrying.robot.command().mount.xyz - carrying.goal.above.xyz).norm(), 1e-9);
  EXPECT_LT((carrying.robot.command().mount.ypr - carrying.goal.above.ypr).norm(), 1e-9);
}

/// An arm whose last joint cannot turn straight to the goal: it has to take another posture.
hand::ArmDescription with_a_limit_on_the_way(const PlaceGoal& goal) {
  hand::ArmDescription arm = hand::six_hinges();
  hand::ArmFollower follower(arm);
  const hand::ArmVector start = follower.reset(Carrying::waiting().mount.pose());
  const auto end = hand::inverse_kinematics(arm, goal.above.pose(), start);
  const double from = start[5], to = end.value()[5];
  hand::Range& range = arm.joints.back().range;
  (to > from ? range.high : range.low) = (from + to) / 2;
  return arm;
}

TEST(TransportPhase, IsPlannedForTheJointsOfAnArmThatCannotFollowLines) {
  for (const bool tells : {true, false}) {
    Carrying carrying({});
    carrying.hand.tells = tells;
    carrying.hand.arm.emplace(with_a_limit_on_the_way(carrying.goal));
    carrying.hand.arm->reset(Carrying::waiting().mount.pose());
    ASSERT_FALSE(carrying.robot.path_to({carrying.goal.above}).obstacle.empty());
    const auto report = carrying.run();
    EXPECT_EQ(report.status, tells ? PhaseStatus::ok : PhaseStatus::failed) << report.outcome;
    if (!tells) continue;
    const auto there = carrying.robot.command().mount.pose().matrix();
    EXPECT_LT((there - carrying.goal.above.pose().matrix()).norm(), 1e-4);
    const std::vector<hand::MountPosition> down = path_down(carrying.goal);
    EXPECT_EQ(carrying.robot.path_to(down).obstacle, "") << "it can come down from there";
  }
}

TEST(TransportPhase, TheFingersBearTheWeightAsTheHandTurns) {
  for (const bool bears : {true, false}) {
    Carrying carrying({});
    carrying.goal.mount.ypr.y() = carrying.goal.above.ypr.y() = 0.6;
    const hand::ActuatorVector before = carrying.robot.command().positions;
    TransportOptions options;
    options.bear_weight = bears;
    const auto report = carrying.run(options);
    EXPECT_EQ(report.status, PhaseStatus::ok) << report.outcome;
    const double change = (carrying.robot.command().positions - before).norm();
    EXPECT_EQ(change > 1e-3, bears) << change;
    EXPECT_EQ(change > 0, bears) << change;
  }
}

TEST(TransportPhase, NoticesTheLossOfTouch) {
  Carrying carrying([](hand::HandReading& reading) {
    if (reading.mount.xyz.x() < 0.1) return;
    for (auto& tip : reading.contacts) tip.clear();
  });
  EXPECT_EQ(carrying.run().status, PhaseStatus::failed);
  EXPECT_TRUE(carrying.lost);
  EXPECT_LT(carrying.robot.command().mount.xyz.x(), 0.19);  // it stopped on the way
}

TEST(TransportPhase, NoticesTheLossOfWeight) {
  Carrying carrying([](hand::HandReading& reading) {
    if (reading.mount.xyz.x() > 0.1) reading.mount_force.z() = 0.1;
  });
  const auto report = carrying.run();
  EXPECT_EQ(report.status, PhaseStatus::failed);
  EXPECT_TRUE(carrying.lost) << report.outcome;
}

TEST(TransportPhase, NoticesSlip) {
  Carrying carrying([](hand::HandReading& reading) {
    if (reading.mount.xyz.x() < 0.1) return;
    for (auto& tip : reading.contacts) tip[0].p.z() -= 0.02;
  });
  const auto report = carrying.run();
  EXPECT_EQ(report.status, PhaseStatus::failed);
  EXPECT_FALSE(carrying.lost);
  EXPECT_NE(report.outcome.find("slipped"), std::string::npos) << report.outcome;
}

TEST(TransportPhase, AGoalInTheTableIsNoGoal) {
  Carrying carrying({});
  carrying.goal.above.xyz.z() = 0.3;  // the box would be 3 cm deep
  const auto report = carrying.run();
  EXPECT_EQ(report.status, PhaseStatus::failed);
  EXPECT_NE(report.outcome.find("table"), std::string::npos) << report.outcome;
  EXPECT_EQ(carrying.robot.command().mount.xyz, Carrying::waiting().mount.xyz);
}

/// 30 cm below the mount, as it lies in its first stable pose.
HeldObject held_below(const geometry::KnownObject& object) {
  HeldObject held;
  held.T_mount_object_flat.translation() << 0, 0, -0.3;
  held.T_mount_object_flat.linear() = object.stable_poses[0].R_table_object;
  held.T_mount_object = held.T_mount_object_flat;
  return held;
}

TEST(FindGoal, BringsTheObjectToTheTarget) {
  const auto box = geometry::load_known_object("box");
  Carrying carrying({});
  HeldObject held;
  held.T_mount_object.translation() << 0.01, 0.02, -0.3;
  held.T_mount_object_flat = held.T_mount_object;
  held.T_mount_object_flat.linear() = box.stable_poses[0].R_table_object;
  held.found_stable_pose = 0;
  const auto target = resting_pose(box, 0, {0.2, 0.1}, 2.0);
  const auto search = find_goal(box, held, target, carrying.robot.reading(), carrying.scene, {});
  ASSERT_TRUE(search.goal) << search.obstacle;
  EXPECT_TRUE(search.same_stable_pose);
  const Eigen::Isometry3d there = search.goal->mount.pose() * search.goal->T_mount_object;
  EXPECT_LT((there.matrix() - search.goal->T_world_object.matrix()).norm(), 1e-9);
  const auto error = localization::pose_error(there, target, box.symmetries);
  EXPECT_LT(error.rotation, 1e-6);
  EXPECT_LT(error.translation, 1e-9);
  EXPECT_LT(std::abs(search.goal->mount.ypr.x()), 1.6);  // the box is the same from behind
}

TEST(FindGoal, TurnsTheOtherWayRoundWhereTheArmCannotGo) {
  const auto box = geometry::load_known_object("box");
  Carrying carrying({});
  const HeldObject held = held_below(box);
  const auto target = resting_pose(box, 0, {0.2, 0.1}, 1.0);
  const auto& now = carrying.robot.reading();
  const auto nearest = find_goal(box, held, target, now, carrying.scene, {});
  ASSERT_TRUE(nearest.goal) << nearest.obstacle;

  const double yaw = nearest.goal->mount.ypr.x();
  const auto search =
      find_goal(box, held, target, now, carrying.scene, {}, [&](const PlaceGoal& goal) {
        EXPECT_EQ(goal.above.ypr, goal.mount.ypr);
        return std::abs(goal.mount.ypr.x() - yaw) < 4 ? "a joint ends there" : "";
      });
  ASSERT_TRUE(search.goal) << search.obstacle;
  EXPECT_FALSE(search.out_of_reach);
  EXPECT_NEAR(std::abs(search.goal->mount.ypr.x() - yaw), 2 * M_PI, 1e-9);
  const Eigen::Isometry3d there = search.goal->mount.pose() * search.goal->T_mount_object;
  EXPECT_LT((there.matrix() - search.goal->T_world_object.matrix()).norm(), 1e-9);

  const auto none = find_goal(box, held, target, now, carrying.scene, {},
                              [](const PlaceGoal&) { return "a joint ends there"; });
  EXPECT_FALSE(none.goal);
  EXPECT_TRUE(none.out_of_reach);
  EXPECT_EQ(none.obstacle, "a joint ends there");
}

TEST(FindGoal, KnowsHowMuchLowerTheObjectHangs) {
  const auto box = geometry::load_known_object("box");
  Carrying carrying({});
  HeldObject held = held_below(box);
  held.T_mount_object.translation().z() -= 0.009;
  const auto target = resting_pose(box, 0, {0.2, 0.1}, 0.0);
  const auto search = find_goal(box, held, target, carrying.robot.reading(), carrying.scene, {});
  ASSERT_TRUE(search.goal) << search.obstacle;
  EXPECT_NEAR(search.goal->sunk, 0.009, 1e-6);
}

TEST(FindGoal, SaysWhatIsInTheWay) {
  const auto box = geometry::load_known_object("box");
  Carrying carrying({});
  HeldObject held;
  held.T_mount_object_flat.translation() << 0, 0, 0.05;  // over the hand: it would be in the table
  held.T_mount_object_flat.linear() = box.stable_poses[0].R_table_object;
  const auto target = resting_pose(box, 0, {0.2, 0.1}, 0.0);
  auto search = find_goal(box, held, target, carrying.robot.reading(), carrying.scene, {});
  EXPECT_FALSE(search.goal);
  EXPECT_NE(search.obstacle.find("table"), std::string::npos) << search.obstacle;

  held.T_mount_object_flat.translation() << 2, 0, -0.3;
  search = find_goal(box, held, target, carrying.robot.reading(), carrying.scene, {});
  EXPECT_FALSE(search.goal);
  EXPECT_NE(search.obstacle.find("out of reach"), std::string::npos) << search.obstacle;
}

}  // namespace
}  // namespace palpate::skills
