// SPDX-License-Identifier: Apache-2.0
#include "palpate/grasping/grasp_plan.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "palpate/evaluation/trial.hpp"
#include "palpate/hand/shadow.hpp"

namespace palpate::grasping {
namespace {

using std::numbers::pi;

constexpr double kPitch = 0.475;
constexpr double kRoll = -0.3;
constexpr double kHalfOpen = 0.094;

/// The Shadow hand, opened as for a grasp from above.
ClosingTrajectory shadow_path(const geometry::ObjectModel& object) {
  simulation::World world(object.object(), {}, 1);
  hand::ActuatorVector open = hand::ActuatorVector::Zero(hand::kShadowActuators);
  for (const std::string finger : {"FF", "MF", "RF", "LF"}) {
    open[hand::shadow_hand().actuator(finger + "J3")] = kHalfOpen;
    open[hand::shadow_hand().actuator(finger + "J0")] = 0.54;
  }
  open[hand::shadow_hand().actuator("THJ5")] = -0.2;
  open[hand::shadow_hand().actuator("THJ4")] = 1.03;
  open[hand::shadow_hand().actuator("THJ2")] = -0.21;
  const hand::Description& hand = world.hand_model();
  return closing_trajectory(hand, open, ClosingLaw(hand, 1.0, hand.postures.top.closed));
}

struct BoxScene {
  geometry::ObjectModel object{geometry::load_known_object("box")};
  ClosingTrajectory path = shadow_path(object);
  Eigen::Isometry3d resting(double yaw, const Eigen::Vector2d& xy, std::size_t index = 0) const {
    const auto& stable_pose = object.object().stable_poses[index];
    Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
    T.linear() = Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ()) * stable_pose.R_table_object;
    T.translation() << xy, stable_pose.height;
    return T;
  }
};

TEST(PlanGrasp, HoldsALyingBoxWhereverItLies) {
  const BoxScene scene;
  GraspPlanOptions options;
  options.press = 3 * 9.81 * scene.object.object().mass;
  for (const double yaw : {0.0, 1.1, 2.5}) {
    const Eigen::Vector2d xy(0.03 * std::cos(3 * yaw), -0.02);
    const auto plan =
        plan_grasp(scene.object, scene.resting(yaw, xy), scene.path, {kPitch, kRoll}, options);
    ASSERT_TRUE(plan);
    EXPECT_LT(plan->cost, 0.3);
    EXPECT_GE(plan->fingers, 3);
    EXPECT_LT((plan->mount.xyz.head<2>() - xy).norm(), 0.15);
    EXPECT_EQ(plan->mount.ypr.y(), kPitch);
    EXPECT_EQ(plan->mount.ypr.z(), kRoll);
  }
}

TEST(PlanGrasp, SomeAttitudeOfTheShadowHandHoldsTheBoxHoweverItStands) {
  const BoxScene scene;
  const auto& attitudes = hand::shadow_hand().postures.top.attitudes;
  for (std::size_t i = 0; i < scene.object.object().stable_poses.size(); ++i) {
    const auto T = scene.resting(0.4, {0, 0}, i);
    EXPECT_TRUE(
        std::any_of(attitudes.begin(), attitudes.end(),
                    [&](const auto& attitude) {
                      return plan_grasp(scene.object, T, scene.path, attitude, {}).has_value();
                    }))
        << "stable pose " << i;
  }
}

TEST(PlanGrasp, HoldsTheObjectInAllPosesThatItMayHave) {
  const BoxScene scene;
  const Eigen::Isometry3d one = scene.resting(0.4, {0, 0}), other = scene.resting(0.8, {0.01, 0});
  const auto expected = [&](GraspPlan plan) {
    const auto here = close_virtually(scene.object, one, scene.path, plan.mount, {});
    const auto there = close_virtually(scene.object, other, scene.path, plan.mount, {});
    plan.cost = here->cost;
    return (0.6 * mean_cost(scene.object, one, scene.path, {}, plan) +
            0.2 * (there ? std::min(1.5, there->cost) : 1.5)) /
           0.8;
  };
  const auto alone = plan_grasp(scene.object, one, scene.path, {kPitch, kRoll}, {});
  const auto both =
      plan_grasp(scene.object, {{one, 0.6}, {other, 0.2}}, scene.path, {kPitch, kRoll}, {});
  ASSERT_TRUE(alone && both);
  EXPECT_EQ(alone->expected_cost, alone->cost);
  EXPECT_NEAR(both->expected_cost, expected(*both), 1e-12);
  EXPECT_LT(both->expected_cost, expected(*alone)) << "the best one for one pose is worse for both";
  EXPECT_GE(both->cost, alone->cost);
}

TEST(PlanGrasp, PosesWithoutWeightAreRefused) {
  const BoxScene scene;
  const auto plan = [&](const std::vector<PossiblePose>& poses) {
    return plan_grasp(scene.object, poses, scene.path, {kPitch, kRoll}, {});
  };
  EXPECT_THROW(static_cast<void>(plan({})), std::invalid_argument);
  EXPECT_THROW(static_cast<void>(plan({{scene.resting(0, {0, 0}), 0.0}})), std::invalid_argument);
}

TEST(PlanGrasp, AvoidsDirectionsThatFailed) {
  const BoxScene scene;
  const auto T = scene.resting(0.4, {0, 0});
  const auto first = plan_grasp(scene.object, T, scene.path, {kPitch, kRoll}, {});
  ASSERT_TRUE(first);
  const double yaw = first->mount.ypr.x();
  const auto second = plan_grasp(scene.object, T, scene.path, {kPitch, kRoll}, {}, {yaw});
  ASSERT_TRUE(second);
  EXPECT_GT(std::abs(std::remainder(second->mount.ypr.x() - yaw, 2 * pi)), 0.3);
}

TEST(PlanGrasp, FindsNothingWhereAllDirectionsHaveFailed) {
  const BoxScene scene;
  std::vector<double> all;
  for (int i = 0; i < 12; ++i) all.push_back(i * pi / 6);
  EXPECT_FALSE(
      plan_grasp(scene.object, scene.resting(0, {0, 0}), scene.path, {kPitch, kRoll}, {}, all));
}

TEST(CloseAt, IsWhatThePlanForesawAndNothingWhereTheHandWouldLandOnTheObject) {
  const BoxScene scene;
  const auto T = scene.resting(0.4, {0, 0});
  const auto grasps = find_grasps(scene.object, T, scene.path, {kPitch, kRoll}, {});
  ASSERT_FALSE(grasps.empty());
  const GraspPlan& grasp = grasps.front();
  const auto again = close_virtually(scene.object, T, scene.path, grasp.mount, {});
  ASSERT_TRUE(again);
  EXPECT_EQ(again->cost, grasp.cost);
  EXPECT_EQ(again->stops, grasp.stops);
  Eigen::Isometry3d below_palm = T;  // the object where the palm comes down
  below_palm.translation().head<2>() = grasp.mount.xyz.head<2>();
  EXPECT_FALSE(close_virtually(scene.object, below_palm, scene.path, grasp.mount, {}));
}

}  // namespace
}  // namespace palpate::grasping
