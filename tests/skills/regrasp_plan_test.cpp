// SPDX-License-Identifier: Apache-2.0
#include "palpate/skills/reorient/regrasp_plan.hpp"

#include <gtest/gtest.h>

#include <limits>
#include <numbers>

#include "palpate/core/error.hpp"
#include "palpate/core/gravity.hpp"
#include "palpate/hand/kinematics.hpp"
#include "palpate/simulation/collision/collision_scene.hpp"
#include "palpate/simulation/hand/load_hand.hpp"
#include "palpate/simulation/world/world.hpp"
#include "palpate/skills/grasp/grasp_phase.hpp"
#include "palpate/skills/place/place_target.hpp"

namespace palpate::skills {
namespace {

/// An object, the hand's tool, and the poses that the tests start from and go to.
struct Table {
  explicit Table(const std::string& name, std::uint64_t seed = 1)
      : object(geometry::load_known_object(name)),
        world(object.object(), {}, seed),
        tool(regrasp_tool(world.hand_model())) {
    options.grasp.press = std::max(5.0, 3 * object.object().mass * kGravity);
  }

  /// The stable pose in which this direction of the object points most nearly up.
  Eigen::Isometry3d resting(const Eigen::Vector3d& up, double yaw,
                            const Eigen::Vector2d& xy) const {
    const geometry::StablePose* best = nullptr;
    double most = -std::numeric_limits<double>::infinity();
    for (const auto& stable_pose : object.object().stable_poses) {
      const double share = stable_pose.R_table_object.row(2).dot(up);
      if (share <= most) continue;
      most = share;
      best = &stable_pose;
    }
    Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
    T.linear() = Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ()) * best->R_table_object;
    T.translation() << xy, best->height;
    return T;
  }

  RegraspPlan plan(const Eigen::Isometry3d& from, const Eigen::Isometry3d& to,
                   const std::optional<Holding>& holding = {}) const {
    return plan_regrasp(object, world.hand_model(), tool, from, to, options, holding);
  }

  geometry::ObjectModel object;
  simulation::World world;
  GraspTool tool;
  RegraspOptions options;
};

/// Every transfer starts where the one before ended, keeps the object still in the hand, and lets
/// go where the opened hand meets neither table nor object; the last one ends at the target.
void expect_sound(const Table& table, const RegraspPlan& plan, const Eigen::Isometry3d& from,
                  const Eigen::Isometry3d& to) {
  const hand::Description hand = simulation::load_hand("shadow");
  simulation::CollisionScene scene(table.object.object(), hand);
  const auto open = hand::joints_in_free_flexion(hand, hand.postures.top.open);
  Eigen::Isometry3d at = from;
  for (const Transfer& transfer : plan.transfers) {
    EXPECT_TRUE(transfer.T_world_from.isApprox(at, 1e-6));
    ASSERT_TRUE(transfer.grasp);
    const Eigen::Isometry3d held = transfer.grasp->mount.pose().inverse() * transfer.T_world_from;
    EXPECT_TRUE((transfer.release.pose() * held).isApprox(transfer.T_world_to, 1e-6));
    for (const auto& mount : {transfer.grasp->mount, transfer.release}) {
      scene.place(mount.pose() * held);
      const auto pair = scene.deepest_collision(mount, open);
      EXPECT_FALSE(pair) << pair->first << " and " << pair->second << " " << pair->depth;
    }
    at = transfer.T_world_to;
  }
  const auto error = localization::pose_error(at, to, table.object.object().symmetries);
  EXPECT_LT(error.rotation, 1e-6);
  EXPECT_LT(error.translation, 1e-6);
}

const StrategyReport* report_of(const RegraspPlan& plan, PlaceStrategy strategy) {
  for (const auto& report : plan.considered) {
    if (report.strategy == strategy) return &report;
  }
  return nullptr;
}

TEST(PlanRegrasp, StandsALyingBoxUpInOneGo) {
  const Table table("box");
  const auto from = table.resting({1, 0, 0}, 0.3, {0.01, 0});
  const auto to = table.resting({0, 0, 1}, 1.0, {0.1, 0.05});
  const auto plan = table.plan(from, to);
  ASSERT_TRUE(plan.found);
  EXPECT_EQ(plan.strategy, PlaceStrategy::wrist);
  EXPECT_EQ(plan.transfers.size(), 1u);
  expect_sound(table, plan, from, to);
  const auto again = table.plan(from, to);
  EXPECT_EQ(plan.cost, again.cost);
  EXPECT_EQ(plan.transfers.front().release.ypr, again.transfers.front().release.ypr);
}

TEST(PlanRegrasp, LaysAStandingBoxAndBracketDown) {
  for (const char* name : {"box", "bracket"}) {
    const Table table(name);
    const auto& object = table.object.object();
    const std::size_t standing =
        object.stable_poses.size() - 1;  // both stand in their rarest stable pose
    const auto from = resting_pose(object, standing, {0.01, 0}, 0.3);
    const auto to = resting_pose(object, 0, {0.25, 0.15}, 0);
    const auto plan = table.plan(from, to);
    EXPECT_TRUE(plan.found) << name;
    expect_sound(table, plan, from, to);
  }
}

TEST(PlanRegrasp, KeepsToWhereTheHandCanBeBrought) {
  Table table("box");
  const auto from = table.resting({1, 0, 0}, 0.3, {0.01, 0});
  const auto to = table.resting({0, 0, 1}, 1.0, {0.1, 0.05});
  const auto anywhere = table.plan(from, to);
  ASSERT_EQ(anywhere.transfers.size(), 1u);
  const auto away_from = [](const hand::MountPosition& refused) {
    return [refused](const hand::MountPosition& mount) {
      return (mount.ypr - refused.ypr).norm() > 0.2;
    };
  };
  const auto everywhere = [](const hand::MountPosition&) { return true; };
  table.tool.reaches = everywhere;
  table.tool.releases = away_from(anywhere.transfers.front().release);
  auto elsewhere = table.plan(from, to);
  ASSERT_EQ(elsewhere.transfers.size(), 1u);
  EXPECT_TRUE(table.tool.releases(elsewhere.transfers.front().release));
  expect_sound(table, elsewhere, from, to);
  table.tool.reaches = away_from(anywhere.transfers.front().grasp->mount);
  table.tool.releases = everywhere;
  elsewhere = table.plan(from, to);
  ASSERT_EQ(elsewhere.transfers.size(), 1u);
  EXPECT_TRUE(table.tool.reaches(elsewhere.transfers.front().grasp->mount));

  table.tool.reaches = [](const hand::MountPosition&) { return false; };
  const auto nowhere = table.plan(from, to);
  EXPECT_FALSE(nowhere.found);
  ASSERT_TRUE(report_of(nowhere, PlaceStrategy::wrist));
  EXPECT_NE(report_of(nowhere, PlaceStrategy::wrist)->reason.find("cannot bring"),
            std::string::npos)
      << report_of(nowhere, PlaceStrategy::wrist)->reason;
}

TEST(PlanRegrasp, StandsALyingBottleUp) {
  const Table table("bottle");
  const auto from = table.resting({0, 1, 0}, -2.0, {0, 0.02});
  const auto to = table.resting({0, 0, 1}, 0, {0.1, 0});
  const auto plan = table.plan(from, to);
  ASSERT_TRUE(plan.found);
  EXPECT_EQ(plan.strategy, PlaceStrategy::wrist);
  expect_sound(table, plan, from, to);
}

TEST(PlanRegrasp, TurnsAMugOverBySettingItDownOnItsSide) {
  Table table("mug");
  const Eigen::Vector2d place(0.2, -0.1);
  const auto from = table.resting({0, 0, -1}, 0.7, place);
  const auto to = table.resting({0, 0, 1}, 2.0, {0.05, 0.05});
  const auto plan = table.plan(from, to);
  ASSERT_TRUE(plan.found);
  EXPECT_EQ(plan.strategy, PlaceStrategy::regrasp);
  ASSERT_EQ(plan.transfers.size(), 2u);
  EXPECT_LT((plan.transfers[0].T_world_to.translation().head<2>() - place).norm(), 1e-9);
  EXPECT_GE(plan.transfers[0].to, 0);
  expect_sound(table, plan, from, to);
  ASSERT_TRUE(report_of(plan, PlaceStrategy::wrist));
  EXPECT_FALSE(report_of(plan, PlaceStrategy::wrist)->possible);
  EXPECT_TRUE(report_of(plan, PlaceStrategy::regrasp)->possible);

  table.options.max_transfers = 1;
  const auto refused = table.plan(from, to);
  EXPECT_FALSE(refused.found);
  EXPECT_TRUE(refused.transfers.empty());
  EXPECT_NE(report_of(refused, PlaceStrategy::wrist)->reason.find("mm above the table"),
            std::string::npos);
}

TEST(PlanRegrasp, TurnsAMugOverWithOtherErrorsOfTheHandToo) {
  for (const std::uint64_t seed : {600u, 603u, 605u}) {  // of the links' places in the model
    const Table table("mug", seed);
    const auto from = table.resting(-Eigen::Vector3d::UnitZ(), 0.4, {0.01, -0.01});
    const auto to = table.resting(Eigen::Vector3d::UnitZ(), -1.1, {0.15, 0.05});
    const RegraspPlan plan = table.plan(from, to);
    ASSERT_TRUE(plan.found) << "seed " << seed;
    expect_sound(table, plan, from, to);
  }
}

TEST(PlanRegrasp, StartsFromTheHandThatHoldsTheObject) {
  const Table table("box");
  const auto from = table.resting({1, 0, 0}, 0.3, {0, 0});
  const auto to = table.resting({0, 0, 1}, 0, {0.1, 0});
  const auto free = table.plan(from, to);
  ASSERT_TRUE(free.found);
  const grasping::GraspPlan& grasp = *free.transfers.front().grasp;
  Holding holding;
  holding.mount = grasp.mount;
  const hand::Description& hand = table.world.hand_model();
  holding.joints = hand::joints_in_free_flexion(hand, hand.postures.top.open);
  const auto plan = table.plan(from, to, holding);
  ASSERT_TRUE(plan.found);
  EXPECT_EQ(plan.strategy, PlaceStrategy::wrist);
  EXPECT_FALSE(plan.transfers.front().grasp);
  EXPECT_EQ(plan.grasps, 0);
  EXPECT_TRUE(
      plan.transfers.front().release.pose().isApprox(free.transfers.front().release.pose(), 1e-6));
}

TEST(PlanRegrasp, MovesNothingAtTheTarget) {
  const Table table("box");
  const auto at = table.resting({1, 0, 0}, 0.3, {0, 0});
  Eigen::Isometry3d turned = at;
  turned.linear() = at.linear() * table.object.object().symmetries[1];
  const auto plan = table.plan(at, turned);
  EXPECT_TRUE(plan.found);
  EXPECT_EQ(plan.strategy, PlaceStrategy::none);
  EXPECT_TRUE(plan.transfers.empty());
}

TEST(PlanRegrasp, RejectsTargetsThatAreNone) {
  const Table table("box");
  const auto at = table.resting({1, 0, 0}, 0, {0, 0});
  Eigen::Isometry3d low = at;
  low.translation().z() -= 0.02;
  EXPECT_THROW((void)table.plan(at, low), BadInput);
  low.translation().z() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW((void)table.plan(at, low), BadInput);
}

}  // namespace
}  // namespace palpate::skills
