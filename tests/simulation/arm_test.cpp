// SPDX-License-Identifier: Apache-2.0
#include "palpate/hand/arm.hpp"

#include <gtest/gtest.h>
#include <mujoco/mujoco.h>

#include <filesystem>
#include <numbers>
#include <vector>

#include "core/error_message.hpp"
#include "palpate/core/error.hpp"
#include "palpate/core/random.hpp"
#include "palpate/core/se3.hpp"
#include "palpate/hand/arm_follower.hpp"
#include "palpate/simulation/hand/hand_store.hpp"
#include "palpate/simulation/hand/load_arm.hpp"
#include "palpate/simulation/hand/load_hand.hpp"
#include "simulation/hand/hand_spec.hpp"
#include "simulation/scenes.hpp"

namespace palpate::simulation {
namespace {

std::string example_arm() {
  const auto root = std::filesystem::path(__FILE__).parent_path().parent_path().parent_path();
  return (root / "examples/arms/six_axes.xml").string();
}

/// The arm of the examples, and those that are installed.
std::vector<std::string> arms() {
  std::vector<std::string> names = {example_arm()};
  for (const StoredHand& arm : stored_arms()) {
    if (!arm.file.empty()) names.push_back(arm.name);
  }
  return names;
}

hand::ArmDescription arm_named(const std::string& name) {
  return *load_arm({.name = name}, load_hand("shadow"));
}

hand::ArmVector random_joints(const hand::ArmDescription& arm, RandomStream& random) {
  hand::ArmVector joints(arm.joint_count());
  for (Eigen::Index i = 0; i < joints.size(); ++i) {
    const hand::Range& range = arm.joints[static_cast<std::size_t>(i)].range;
    joints[i] = random.uniform(std::max(range.low, -3.0), std::min(range.high, 3.0));
  }
  return joints;
}

WorldOptions with_arm(const std::string& name) {
  WorldOptions options = without_noise();
  options.arm.name = name;
  return options;
}

hand::HandCommand waiting(const hand::Description& hand) {
  hand::HandCommand command;
  command.positions.setZero(hand.actuator_count());
  command.mount.xyz = {0, 0, 0.34};
  return command;
}

TEST(Arm, AFloatingHandHasNone) { EXPECT_FALSE(load_arm({}, load_hand("shadow")).has_value()); }

TEST(Arm, WhatIsNoArmIsNamed) {
  const hand::Description hand = load_hand("shadow");
  try {
    (void)load_arm({.name = "crane"}, hand);
    FAIL();
  } catch (const BadInput& error) {
    EXPECT_NE(std::string(error.what()).find("crane"), std::string::npos);
  }
  EXPECT_THROW((void)load_arm({.name = hand.file.path.string()}, hand), BadInput);
}

TEST(Arm, LinksAreWhereTheSimulatorHasThem) {
  for (const std::string& name : arms()) {
    const hand::ArmDescription arm = arm_named(name);
    const SpecHandle spec = parse_model(arm.file.path);
    const ModelHandle model = compile(*spec);
    const DataHandle data = make_data(*model);
    RandomStream random(1, name);
    for (int i = 0; i < 20; ++i) {
      const hand::ArmVector joints = random_joints(arm, random);
      for (int k = 0; k < model->nq; ++k) data->qpos[k] = joints[k];
      mj_kinematics(model.get(), data.get());
      const int flange = find_id(*model, mjOBJ_BODY, arm.file.flange);
      const Eigen::Isometry3d expected =
          arm.T_world_stand * body_pose(*data, flange) * arm.T_flange_mount;
      EXPECT_TRUE(hand::mount_pose(arm, joints).isApprox(expected, 1e-9)) << name;
    }
  }
}

TEST(Arm, TheJacobianIsTheDerivative) {
  const hand::ArmDescription arm = arm_named(example_arm());
  RandomStream random(2, "jacobian");
  const hand::ArmVector joints = random_joints(arm, random);
  const hand::ArmJacobian J = hand::mount_jacobian(arm, joints);
  constexpr double kStep = 1e-6;
  for (Eigen::Index i = 0; i < joints.size(); ++i) {
    hand::ArmVector moved = joints;
    moved[i] += kStep;
    const Eigen::Isometry3d a = hand::mount_pose(arm, joints), b = hand::mount_pose(arm, moved);
    const Eigen::Vector3d w = log_so3(b.linear() * a.linear().transpose()) / kStep;
    const Eigen::Vector3d v = (b.translation() - a.translation()) / kStep;
    EXPECT_LT((J.col(i).head<3>() - w).norm(), 1e-5);
    EXPECT_LT((J.col(i).tail<3>() - v).norm(), 1e-5);
  }
}

TEST(Arm, InverseKinematicsLeadsBackToThePose) {
  for (const std::string& name : arms()) {
    const hand::ArmDescription arm = arm_named(name);
    RandomStream random(3, name);
    int found = 0;
    for (int i = 0; i < 100; ++i) {
      const hand::ArmVector joints = random_joints(arm, random);
      const Eigen::Isometry3d T = hand::mount_pose(arm, joints);
      const hand::ArmVector near = joints.array() + 0.2 * random.normal();
      const auto solution = hand::inverse_kinematics(arm, T, near);
      if (!solution) continue;  // it has met a limit
      ++found;
      EXPECT_LT((hand::mount_pose(arm, *solution).matrix() - T.matrix()).norm(), 1e-4) << name;
      for (Eigen::Index k = 0; k < solution->size(); ++k) {
        const hand::Range& range = arm.joints[static_cast<std::size_t>(k)].range;
        EXPECT_GE((*solution)[k], range.low);
        EXPECT_LE((*solution)[k], range.high);
      }
    }
    EXPECT_GE(found, 80) << name;
  }
}

TEST(Arm, BranchesAreDifferentSolutions) {
  const hand::ArmDescription arm = arm_named(example_arm());
  const Eigen::Isometry3d T(Eigen::Translation3d(0, 0, 0.3));
  const auto branches = hand::inverse_kinematics_branches(arm, T);
  EXPECT_GE(branches.size(), 4u);
  for (std::size_t i = 0; i < branches.size(); ++i) {
    EXPECT_LT((hand::mount_pose(arm, branches[i]).matrix() - T.matrix()).norm(), 1e-4);
    for (std::size_t k = 0; k < i; ++k) {
      EXPECT_GT((branches[i] - branches[k]).cwiseAbs().maxCoeff(), 0.1);
    }
  }
}

TEST(Arm, WhatLiesBelowTheTableOrInItselfIsACollision) {
  const hand::ArmDescription arm = arm_named(example_arm());
  hand::ArmVector joints = hand::ArmVector::Zero(6);
  joints[1] = -0.5 * std::numbers::pi;  // straight up
  EXPECT_EQ(hand::arm_collision(arm, joints), "");
  joints[1] = 0.6;
  EXPECT_NE(hand::arm_collision(arm, joints).find("the table"), std::string::npos);
  joints[1] = -0.5 * std::numbers::pi;
  joints[2] = 3.05;  // folded back
  EXPECT_NE(hand::arm_collision(arm, joints), "");
}

TEST(ArmFollower, KeepsLimitsOfSpeedAndAcceleration) {
  const hand::ArmDescription arm = arm_named(example_arm());
  hand::ArmFollower follower(arm);
  hand::MountPosition mount{{0, 0, 0.3}, {0, 0, 0}};
  hand::ArmVector before = follower.reset(mount.pose());
  hand::ArmVector speeds = hand::ArmVector::Zero(6);
  mount.xyz.x() += 0.1;  // at once
  for (int i = 0; i < 200; ++i) {
    const hand::ArmVector joints = follower.follow(mount.pose());
    for (Eigen::Index k = 0; k < 6; ++k) {
      const hand::ArmJoint& joint = arm.joints[static_cast<std::size_t>(k)];
      const double speed = (joints[k] - before[k]) / hand::kTick;
      EXPECT_LE(std::abs(speed), joint.max_speed * (1 + 1e-6));
      EXPECT_LE(std::abs(speed - speeds[k]), joint.max_acceleration * hand::kTick * (1 + 1e-6));
      speeds[k] = speed;
    }
    before = joints;
  }
  EXPECT_LT((hand::mount_pose(arm, before).matrix() - mount.pose().matrix()).norm(), 1e-3);
}

TEST(ArmFollower, ComesToRestWithinTheBrakingDistance) {
  hand::ArmFollower follower(arm_named(example_arm()));
  Eigen::Isometry3d T(Eigen::Translation3d(0, 0, 0.3));
  hand::ArmVector before = follower.reset(T);
  for (int i = 0; i < 40; ++i) {  // to 0.5 m/s, which then stops at once
    before = follower.joints();
    T.translation().x() += 0.005;
    follower.follow(T);
  }
  const hand::ArmVector speeds = (follower.joints() - before) / hand::kTick;
  std::vector<hand::ArmVector> way;
  for (int i = 0; i < 300; ++i) way.push_back(follower.follow(T));
  EXPECT_TRUE(hand::mount_pose(follower.arm(), way.back()).isApprox(T, 1e-4));
  for (Eigen::Index k = 0; k < 6; ++k) {
    const double speed = std::abs(speeds[k]);
    const double braking =
        speed * speed / (2 * follower.arm().joints[static_cast<std::size_t>(k)].max_acceleration);
    for (const hand::ArmVector& joints : way) {
      const double passed = std::copysign(1.0, speeds[k]) * (joints[k] - way.back()[k]);
      EXPECT_LE(passed, braking + 2 * speed * hand::kTick + 1e-4) << k;
    }
  }
}

TEST(ArmFollower, JudgesAWayBeforeItBegins) {
  hand::ArmFollower follower(arm_named(example_arm()));
  const hand::MountPosition start{{0, 0, 0.3}, {0, 0, 0}};
  follower.reset(start.pose());
  std::vector<hand::MountPosition> slow, fast, far;
  for (int i = 1; i <= 100; ++i) {
    const double share = 0.01 * i;
    const double eased = 0.1 * share * share * (3 - 2 * share);
    slow.push_back({start.xyz + Eigen::Vector3d(eased, 0, 0), start.ypr});
    fast.push_back({start.xyz, start.ypr + Eigen::Vector3d(0.05 * i, 0, 0)});
    far.push_back({start.xyz + Eigen::Vector3d(0, 0, 0.03 * i), start.ypr});
  }
  const hand::PathFeasibility easy = follower.check_path(slow);
  EXPECT_EQ(easy.obstacle, "");
  EXPECT_EQ(easy.stretch, 1);
  EXPECT_GT(follower.check_path(std::span(fast).first(20)).stretch, 1);
  const hand::PathFeasibility reaching = follower.check_path(far);
  EXPECT_FALSE(reaching.obstacle.empty());
  EXPECT_GT(reaching.feasible, 0u);
  EXPECT_LT(reaching.feasible, 50u) << "1.5 m higher than it began";
}

/// What the arm meets where it is may be left. It excuses nothing afterwards.
TEST(ArmFollower, AWayThatLeavesACollisionMayNotEnterAnother) {
  hand::ArmDescription arm = arm_named(example_arm());
  arm.spheres.clear();
  arm.carried.clear();
  const auto link = static_cast<int>(arm.links.size()) - 1;
  arm.spheres.push_back({link, Eigen::Vector3d::Zero(), 0.001});
  hand::ArmFollower follower(arm);
  const Eigen::Isometry3d high(Eigen::Translation3d(0, 0, 0.3));
  const hand::ArmVector joints = follower.reset(high);
  const Eigen::Isometry3d T_world_ball =
      hand::link_poses(arm, joints)[static_cast<std::size_t>(link)];
  // A ball of the stand, which is fixed, where the flange is now.
  arm.spheres.insert(
      arm.spheres.begin(),
      {0, hand::link_poses(arm, joints)[0].inverse() * T_world_ball.translation(), 0.02});
  hand::ArmFollower caught(arm);
  EXPECT_THROW(caught.reset(high), BadInput) << "it cannot start there";
  // It comes there by following, and then looks for a way on.
  caught.reset(Eigen::Isometry3d(Eigen::Translation3d(0, 0, 0.35)));
  for (int i = 1; i <= 300; ++i) {
    caught.follow(Eigen::Isometry3d(Eigen::Translation3d(0, 0, std::max(0.3, 0.35 - 0.0005 * i))));
  }
  ASSERT_NE(hand::arm_collision(arm, caught.joints()), "");
  std::vector<hand::MountPosition> way;
  for (int i = 1; i <= 100; ++i) way.push_back({{0, 0, 0.3 + 0.0005 * i}, {0, 0, 0}});
  EXPECT_EQ(caught.check_path(way).obstacle, "") << "leaving is allowed";
  for (int i = 1; i <= 100; ++i) way.push_back({{0, 0, 0.35 - 0.0005 * i}, {0, 0, 0}});
  EXPECT_NE(caught.check_path(way).obstacle, "") << "coming back is not";
}

std::string reason_of_reset(const hand::ArmDescription& arm, const Eigen::Isometry3d& T) {
  hand::ArmFollower follower(arm);
  return error_message([&] { follower.reset(T); });
}

TEST(ArmFollower, SaysWhyItCannotHoldTheHandAtTheStart) {
  hand::ArmDescription arm = arm_named(example_arm());
  const Eigen::Isometry3d far(Eigen::Translation3d(3, 0, 0.3)),
      near(Eigen::Translation3d(0, 0, 0.3));
  const std::string too_far = reason_of_reset(arm, far);
  EXPECT_NE(too_far.find("the inverse kinematics has no solution"), std::string::npos) << too_far;
  arm.spheres.push_back({0, Eigen::Vector3d::Zero(), 5});  // all is within the stand
  const std::string collides = reason_of_reset(arm, near);
  EXPECT_NE(collides.find("would meet"), std::string::npos) << collides;
  EXPECT_NE(collides.find("solutions found"), std::string::npos) << collides;
  while (arm.joint_count() > 5) arm.joints.pop_back();
  for (hand::Link& link : arm.links) {
    if (link.joint >= arm.joint_count()) link.joint = -1;
  }
  const std::string few = reason_of_reset(arm, far);
  EXPECT_NE(few.find("5 joints are fewer than 6"), std::string::npos) << few;
}

TEST(ArmFollower, WhatItCannotHoldAtTheStartIsBadInput) {
  hand::ArmFollower follower(arm_named(example_arm()));
  EXPECT_THROW(follower.reset(Eigen::Isometry3d(Eigen::Translation3d(3, 0, 0.3))), BadInput);
}

TEST(World, AnArmCarriesTheHandToWhereItIsCommanded) {
  World world(block(), with_arm(example_arm()), 1);
  hand::HandCommand command = waiting(world.hand_model());
  world.reset({}, command);
  hand::HandReading reading = world.hand().step(command);
  EXPECT_LT((reading.mount.xyz - command.mount.xyz).norm(), 1e-3);
  std::vector<hand::MountPosition> way;
  for (int i = 1; i <= 100; ++i) {
    way.push_back({command.mount.xyz - Eigen::Vector3d(0, 0, 0.0005 * i),
                   command.mount.ypr + Eigen::Vector3d(0.001 * i, 0, 0)});
  }
  ASSERT_EQ(world.hand().check_path(way).obstacle, "");
  for (const auto& mount : way) {
    command.mount = mount;
    reading = world.hand().step(command);
  }
  for (int i = 0; i < 100; ++i) reading = world.hand().step(command);
  EXPECT_LT((reading.mount.xyz - command.mount.xyz).norm(), 1e-3);
  EXPECT_LT((reading.mount.ypr - command.mount.ypr).norm(), 2e-3);
  EXPECT_LT(reading.mount_force.norm(), 0.5) << "the hand hangs free";
}

TEST(World, AnArmSensesWhatTheHandStandsOn) {
  World world(block(), with_arm(example_arm()), 1);
  hand::HandCommand command = waiting(world.hand_model());
  world.reset({.xy = {0.4, 0.4}}, command);
  hand::HandReading reading;
  for (int i = 0; i < 400 && reading.mount_force.z() > -5; ++i) {
    command.mount.xyz.z() -= 0.001;
    reading = world.hand().step(command);
  }
  EXPECT_LT(reading.mount_force.z(), -5) << "the flange presses the hand onto the table";
}

}  // namespace
}  // namespace palpate::simulation
