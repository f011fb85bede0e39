// SPDX-License-Identifier: Apache-2.0
#include "palpate/planning/arm_planner.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "hand/arms.hpp"
#include "palpate/core/error.hpp"
#include "palpate/simulation/collision/collision_scene.hpp"
#include "planning/motions.hpp"

namespace palpate::planning {
namespace {

constexpr std::uint64_t kSeed = 5;

/// An arm that holds the open hand 0.5 m above the table.
struct Holding {
  Holding() {
    const hand::ArmVector near = (hand::ArmVector(6) << 0.1, 0.6, 1.2, 0.1, 1.2, 0.1).finished();
    mount = open_hand(0, -0.2, 0.5).mount;
    const auto joints = hand::inverse_kinematics(arm, mount.pose(), near);
    if (!joints) throw BadInput("the test's arm does not reach its start");
    start.posture = {&arm, {joints->data(), joints->data() + joints->size()}};
    start.mount = mount;
  }
  Plan plan(const hand::MountPosition& target, PlanOptions options = {}) {
    const std::vector<hand::MountPosition> line = {target, lower(target)};
    return plan_with_arm(start, line, open_hand(0, 0, 0).joints, scene, options, kSeed);
  }
  static hand::MountPosition lower(hand::MountPosition mount) {
    mount.xyz.z() -= 0.02;
    return mount;
  }

  hand::ArmDescription arm = hand::six_hinges();
  hand::MountPosition mount;
  ArmStart start;
  simulation::CollisionScene scene{plate(), drawn_hand()};
};

hand::MountPosition turned(const hand::MountPosition& mount, double y, double yaw) {
  hand::MountPosition target = mount;
  target.xyz.y() += y;
  target.ypr.x() += yaw;
  return target;
}

double distance_to(const hand::MountPosition& a, const hand::MountPosition& b) {
  return (a.pose().matrix() - b.pose().matrix()).norm();
}

/// The arm's joints along a plan, within their limits.
void expect_followed(const Holding& holding, const Plan& plan) {
  hand::ArmVector joints = Eigen::Map<const Eigen::VectorXd>(holding.start.posture.joints.data(),
                                                             holding.arm.joint_count());
  for (std::size_t i = 0; i < plan.samples.size(); ++i) {
    const auto next = hand::inverse_kinematics(holding.arm, plan.samples[i].mount.pose(), joints);
    ASSERT_TRUE(next) << i;
    EXPECT_LT((*next - joints).cwiseAbs().maxCoeff(), 2 * hand::kTick + 1e-3) << i;
    EXPECT_EQ(hand::arm_collision(holding.arm, *next), "") << i;
    joints = *next;
  }
}

TEST(PlanWithArm, BringsTheMountThereWithinTheLimitsOfJointsAndMount) {
  Holding holding;
  const auto target = turned(holding.mount, 0.4, 1.0);
  PlanOptions options;
  options.limits.mount_speed = 0.1;
  const Plan plan = holding.plan(target, options);
  ASSERT_EQ(plan.status, PlanStatus::ok);
  EXPECT_LT(distance_to(plan.samples.front().mount, holding.mount), 1e-6);
  EXPECT_LT(distance_to(plan.samples.back().mount, target), 1e-4);
  EXPECT_GT(plan.duration(), 0.4 / 0.1);
  for (std::size_t i = 1; i < plan.samples.size(); ++i) {
    const auto& a = plan.samples[i - 1].mount;
    const auto& b = plan.samples[i].mount;
    EXPECT_LT((b.xyz - a.xyz).norm(), 0.1 * hand::kTick * 1.05) << i;
    EXPECT_LT((b.ypr - a.ypr).cwiseAbs().maxCoeff(), 0.1) << "no jump of the angles at " << i;
  }
  expect_followed(holding, plan);
}

TEST(PlanWithArm, KeepsWhatTheMountIsOffTheArmsKinematics) {
  Holding holding;
  holding.start.table_height = 0.004;
  holding.start.mount.xyz += Eigen::Vector3d(0.001, -0.001, -0.004);
  holding.start.mount.ypr.x() += 0.005;
  const auto target = turned(holding.start.mount, 0.3, -0.4);
  const Plan plan = holding.plan(target);
  ASSERT_EQ(plan.status, PlanStatus::ok);
  EXPECT_LT(distance_to(plan.samples.front().mount, holding.start.mount), 1e-6);
  EXPECT_LT(distance_to(plan.samples.back().mount, target), 1e-4);
}

TEST(PlanWithArm, GoesAroundWhatIsInTheWay) {
  Holding holding;
  holding.mount.xyz.z() = 0.14;
  const hand::ArmVector near = Eigen::Map<const Eigen::VectorXd>(
      holding.start.posture.joints.data(), holding.arm.joint_count());
  const auto low = hand::inverse_kinematics(holding.arm, holding.mount.pose(), near);
  ASSERT_TRUE(low);
  holding.start.posture.joints.assign(low->data(), low->data() + low->size());
  holding.start.mount = holding.mount;
  holding.scene.place(at(0, 0.05, 0.08));
  const Plan plan = holding.plan(turned(holding.mount, 0.5, 0));
  ASSERT_EQ(plan.status, PlanStatus::ok);
  double highest = 0;
  for (std::size_t i = 0; i < plan.samples.size(); ++i) {
    EXPECT_TRUE(is_free(holding.scene, plan.samples[i])) << i;
    highest = std::max(highest, plan.samples[i].mount.xyz.z());
  }
  EXPECT_GT(highest, 0.16) << "over the plate";
  EXPECT_GT(plan.corners.size(), 2U);
  expect_followed(holding, plan);
}

TEST(PlanWithArm, SaysWhatItCannotReach) {
  Holding holding;
  const auto far = turned(holding.mount, 3.0, 0);
  EXPECT_EQ(holding.plan(far).status, PlanStatus::no_path);
  EXPECT_NE(arm_obstacle(holding.start, std::vector{far}).find("out of reach"), std::string::npos);
  // Over the target, but not down to it.
  const auto over = turned(holding.mount, 0.4, 0);
  const auto below = turned({over.xyz - Eigen::Vector3d(0, 0, 2), over.ypr}, 0, 0);
  EXPECT_EQ(arm_obstacle(holding.start, std::vector{over}), "");
  EXPECT_NE(arm_obstacle(holding.start, std::vector{over, below}), "");
}

TEST(PlanWithArm, RefusesAPostureOfAnotherArm) {
  Holding holding;
  holding.start.posture.joints.pop_back();
  EXPECT_THROW(holding.plan(holding.mount), BadInput);
  holding.start.posture.arm = nullptr;
  EXPECT_THROW(static_cast<void>(arm_obstacle(holding.start, std::vector{holding.mount})),
               BadInput);
}

}  // namespace
}  // namespace palpate::planning
