// SPDX-License-Identifier: Apache-2.0
#include "palpate/simulation/collision/collision_scene.hpp"

#include <gtest/gtest.h>

#include "palpate/core/assets.hpp"
#include "palpate/core/error.hpp"
#include "palpate/hand/kinematics.hpp"
#include "palpate/hand/shadow.hpp"
#include "palpate/simulation/hand/load_hand.hpp"
#include "palpate/simulation/world/world.hpp"
#include "simulation/scenes.hpp"

namespace palpate::simulation {
namespace {

const hand::Description& drawn_hand() {
  static const hand::Description hand = load_hand("shadow");
  return hand;
}

std::optional<planning::CollidingPair> collision(CollisionScene& scene,
                                                 const hand::HandCommand& command) {
  return scene.deepest_collision(command.mount,
                                 hand::joints_in_free_flexion(drawn_hand(), command.positions));
}

bool names(const planning::CollidingPair& pair, std::string_view body) {
  return pair.first == body || pair.second == body;
}

TEST(CollisionScene, OpenHandIsFreeHighAndHitsTheTableLow) {
  CollisionScene scene(drawn_hand());
  EXPECT_FALSE(collision(scene, open_hand(0.3)));
  const auto pair = collision(scene, open_hand(-0.05));
  ASSERT_TRUE(pair);
  EXPECT_TRUE(names(*pair, "table"));
  const auto deeper = collision(scene, open_hand(-0.06));
  ASSERT_TRUE(deeper);
  EXPECT_NEAR(deeper->depth - pair->depth, 0.01, 1e-6);
}

TEST(CollisionScene, FingersHitEachOther) {
  CollisionScene scene(drawn_hand());
  hand::HandCommand crossed = open_hand(0.3);
  crossed.positions[hand::shadow_hand().actuator("FFJ4")] = 0.349;
  const auto pair = collision(scene, crossed);
  ASSERT_TRUE(pair);
  EXPECT_TRUE(pair->first.starts_with("ff") || pair->second.starts_with("ff")) << pair->first;
  EXPECT_TRUE(pair->first.starts_with("mf") || pair->second.starts_with("mf")) << pair->second;
}

TEST(CollisionScene, ObjectIsWhereItIsPlaced) {
  CollisionScene scene(block(), drawn_hand());
  const hand::HandCommand hand = open_hand(0.1);
  EXPECT_FALSE(collision(scene, hand));
  scene.place(Eigen::Isometry3d(Eigen::Translation3d(0, 0, 0.1)));
  const auto pair = collision(scene, hand);
  ASSERT_TRUE(pair);
  EXPECT_TRUE(names(*pair, "object"));
  scene.place(Eigen::Isometry3d(Eigen::Translation3d(1, 0, 0.03)));
  EXPECT_FALSE(collision(scene, hand)) << "an object at rest may touch the table";
}

TEST(CollisionScene, HeldObjectMovesWithThePalmAndMeetsOnlyTheTable) {
  CollisionScene scene(block(), drawn_hand());
  const hand::HandCommand high = open_hand(0.3), low = open_hand(0.12);
  const Eigen::Isometry3d T_world_object(Eigen::Translation3d(0, 0, 0.2));
  const Eigen::Isometry3d T_world_palm =
      scene.palm_pose(high.mount, hand::joints_in_free_flexion(drawn_hand(), high.positions));
  scene.hold(T_world_palm.inverse() * T_world_object);
  EXPECT_FALSE(collision(scene, high));
  EXPECT_FALSE(collision(scene, open_hand(0.135)));
  const auto pair = collision(scene, low);
  ASSERT_TRUE(pair);
  EXPECT_TRUE(names(*pair, "object") && names(*pair, "table")) << pair->first << pair->second;
  EXPECT_NEAR(pair->depth, 0.01, 1e-6);  // the block's half height is 30 mm, its center at 20 mm

  scene.place(T_world_object);
  hand::HandCommand inside = open_hand(0.2);
  EXPECT_TRUE(collision(scene, inside)) << "once placed again the hand must keep clear of it";
}

TEST(CollisionScene, AllowsSomeDepth) {
  CollisionScene strict(drawn_hand(), planning::CollisionOptions{.allowed_depth = 0});
  hand::HandCommand hand = open_hand(-0.05);
  const auto pair = collision(strict, hand);
  ASSERT_TRUE(pair);
  CollisionScene lax(drawn_hand(), planning::CollisionOptions{.allowed_depth = pair->depth + 1e-6});
  EXPECT_FALSE(collision(lax, hand));
}

TEST(CollisionScene, NothingToPlace) {
  CollisionScene scene(drawn_hand());
  EXPECT_THROW(scene.place(Eigen::Isometry3d::Identity()), BadInput);
  EXPECT_THROW(scene.hold(Eigen::Isometry3d::Identity()), BadInput);
}

/// The open hand above the table, its fingers lowest.
hand::HandCommand pointing_down(double height) {
  hand::HandCommand command = open_hand(height);
  command.mount.ypr[1] = 1.2;
  return command;
}

/// Height of the mount, m, at which the hand meets the table, coming down.
double touch_height(CollisionScene& scene) {
  for (double height = 0.5; height > -0.3; height -= 0.0005) {
    const auto pair = collision(scene, pointing_down(height));
    if (pair && names(*pair, "table")) return height;
  }
  return -1;
}

TEST(CollisionScene, IsBuiltFromTheBelievedHand) {
  constexpr double kLower = 0.02;  // m
  const hand::Description& drawn = drawn_hand();
  hand::Description lowered = drawn;
  const auto command = pointing_down(0);
  const auto T_mount_link = hand::forward_kinematics(
      drawn, hand::joints_in_free_flexion(drawn_hand(), command.positions));
  for (auto& link : lowered.links) {
    if (link.parent != -1) continue;
    for (auto& child : lowered.links) {
      if (child.parent < 0 || &lowered.links[static_cast<std::size_t>(child.parent)] != &link)
        continue;
      const Eigen::Matrix3d R_world_parent =
          (command.mount.pose() * T_mount_link[static_cast<std::size_t>(child.parent)]).linear();
      child.T_parent_link.translation() -= kLower * R_world_parent.row(2).transpose();
    }
  }
  CollisionScene nominal(block(), drawn), believed(block(), lowered);
  EXPECT_NEAR(touch_height(believed) - touch_height(nominal), kLower, 0.001);
  hand::Description other = drawn;
  other.links[1].name = "tentacle";
  EXPECT_THROW((void)CollisionScene(block(), other), BadInput);
}

}  // namespace
}  // namespace palpate::simulation
