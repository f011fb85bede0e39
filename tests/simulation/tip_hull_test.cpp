// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>

#include "hand_files.hpp"
#include "palpate/geometry/query/rounded_hull.hpp"
#include "palpate/hand/kinematics.hpp"
#include "palpate/simulation/collision/collision_scene.hpp"
#include "palpate/simulation/hand/describe_hand.hpp"
#include "simulation/hand/hand_spec.hpp"

namespace palpate::simulation {
namespace {

const std::string kTip =
    "<joint name=\"index_2\" axis=\"0 1 0\" range=\"0 1.4\"/>\n          "
    "<geom type=\"capsule\" size=\"0.008\" fromto=\"0.008 0 0 0.03 0 0\"/>";

HandNotes hulls() {
  HandNotes notes;
  notes.tip_shape = "hull";
  return notes;
}

/// A hand whose index has this geom for a fingertip.
hand::Description with_tip(const std::string& name, const std::string& geom) {
  const std::string joint = kTip.substr(0, kTip.find('\n') + 1);
  return describe_hand(write_hand(name + ".xml", replaced(kHandMjcf, kTip, joint + geom)), hulls())
      .hand;
}

const hand::TipHull& hull_of(const hand::Description& hand) { return *hand.fingers[0].hull; }

Eigen::AlignedBox3d extent(const hand::TipHull& hull) {
  Eigen::AlignedBox3d box;
  for (const auto& p : hull.core) box.extend(p);
  return {box.min().array() - hull.radius, box.max().array() + hull.radius};
}

TEST(TipHull, OfABoxIsTheBox) {
  const auto hand =
      with_tip("box", R"(<geom type="box" size="0.014 0.006 0.005" pos="0.016 0.001 0"/>)");
  ASSERT_TRUE(hand.fingers[0].hull);
  EXPECT_FALSE(hand.fingers[1].hull) << "a capsule stays one";
  const auto box = extent(hull_of(hand));
  EXPECT_LT((box.max() - Eigen::Vector3d(0.03, 0.007, 0.005)).norm(), 1e-6);
  EXPECT_LT((box.min() - Eigen::Vector3d(0.002, -0.005, -0.005)).norm(), 1e-6);
}

TEST(TipHull, AnEulerAngleOfTheFileTurnsItOnce) {
  const auto hand = with_tip(
      "euler",
      R"(<geom type="box" size="0.005 0.006 0.014" pos="0.016 0 0" euler="0 1.5707963 0"/>)");
  const SpecHandle spec = parse_hand(hand);
  const ModelHandle model = compile(*spec);
  const int geom = find_id(*model, mjOBJ_GEOM, tip_geom(hand, 0));
  const Eigen::Isometry3d T = pose3(model->geom_pos + 3 * geom, model->geom_quat + 4 * geom);
  Eigen::AlignedBox3d drawn;
  const float* const vertices =
      model->mesh_vert + 3 * model->mesh_vertadr[model->geom_dataid[geom]];
  for (int i = 0; i < model->mesh_vertnum[model->geom_dataid[geom]]; ++i) {
    drawn.extend(T * Eigen::Vector3f(vertices + 3 * i).cast<double>());
  }
  EXPECT_LT((drawn.max() - Eigen::Vector3d(0.03, 0.006, 0.005)).norm(), 1e-5);
}

TEST(TipHull, ALongFingertipEndsWhereItsCapsuleDoes) {
  const auto hand =
      with_tip("long", R"(<geom type="box" size="0.03 0.005 0.005" pos="0.03 0 0"/>)");
  const auto box = extent(hull_of(hand));
  EXPECT_NEAR(box.max().x(), 0.06, 1e-6);
  EXPECT_NEAR(box.sizes().x(), 0.025 + 2 * 0.005, 1e-6);
}

TEST(TipHull, CylindersAndSeveralGeomsAreCovered) {
  const auto round = with_tip(
      "cylinder",
      R"(<geom type="cylinder" size="0.006 0.012" pos="0.016 0 0" euler="0 1.5707963 0"/>)");
  EXPECT_NEAR(extent(hull_of(round)).max().x(), 0.028, 1e-6);
  EXPECT_NEAR(extent(hull_of(round)).sizes().y(), 0.012, 1e-4);
  const auto two = with_tip("two", R"(<geom type="box" size="0.01 0.006 0.005" pos="0.01 0 0"/>
      <geom type="box" size="0.004 0.004 0.005" pos="0.024 0 0.001"/>)");
  EXPECT_NEAR(extent(hull_of(two)).max().x(), 0.028, 1e-6);
  EXPECT_NEAR(extent(hull_of(two)).sizes().y(), 0.012, 1e-6);
}

TEST(TipHull, ACapsuleIsFittedUnlessTheNotesSayOtherwise) {
  const auto hand = describe_hand(write_hand("mimic.urdf", kHandUrdf)).hand;
  for (const auto& finger : hand.fingers) EXPECT_FALSE(finger.hull);
}

TEST(TipHull, TheBallsOfTheTipLieWithinIt) {
  const auto hand = describe_hand(write_hand("mimic.urdf", kHandUrdf), hulls()).hand;
  const geometry::RoundedHull hull(hull_of(hand).core, hull_of(hand).radius);
  double farthest = 0;
  for (const auto& ball : hand.spheres) {
    if (ball.link != hand.fingers[0].link) continue;
    EXPECT_LE(hull.above_facets(ball.center) + ball.radius, hull.radius() + 1e-9);
    farthest = std::max(farthest, ball.center.x() + ball.radius);
  }
  EXPECT_NEAR(farthest, 0.04, 1e-6);
}

class TipHullInAScene : public testing::Test {
 protected:
  /// Lowest point of the index's hull, in the world.
  Eigen::Vector3d lowest() const {
    const auto T =
        mount_.pose() *
        hand::forward_kinematics(hand_, joints_)[static_cast<std::size_t>(hand_.fingers[0].link)];
    Eigen::Vector3d low = Eigen::Vector3d::Constant(1);
    for (const auto& p : hull_of(hand_).core) {
      if ((T * p).z() < low.z()) low = T * p;
    }
    return low - hull_of(hand_).radius * Eigen::Vector3d::UnitZ();
  }

  hand::Description hand_ = describe_hand(write_hand("mimic.urdf", kHandUrdf), hulls()).hand;
  hand::JointVector joints_ =
      hand::joints_in_free_flexion(hand_, (hand::ActuatorVector(2) << 0.9, 0.2).finished());
  hand::MountPosition mount_{{0, 0, 0.3}, {0.3, 0.1, 0.2}};
};

TEST_F(TipHullInAScene, ItMeetsTheTableWithItsRoundedCorners) {
  CollisionScene scene(hand_, {.allowed_depth = 0, .self = false});
  mount_.xyz.z() -= lowest().z() + 0.0006;
  const auto pair = scene.deepest_collision(mount_, joints_);
  ASSERT_TRUE(pair);
  EXPECT_EQ(pair->first == "table" ? pair->second : pair->first, "finger_tip");
  EXPECT_NEAR(pair->depth, 0.0006, 1e-9);
  mount_.xyz.z() += 0.0007;
  EXPECT_FALSE(scene.deepest_collision(mount_, joints_));
}

TEST_F(TipHullInAScene, ItMeetsTheTrueSurfaceOfAnObject) {
  const auto object = geometry::load_known_object("box");
  double top = 0;
  for (const auto& p : object.mesh.vertices) top = std::max(top, p.z());
  CollisionScene scene(object, hand_, {.allowed_depth = 0, .self = false});
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.translation() = lowest() + Eigen::Vector3d(0, 0, 0.0006 - top);
  scene.place(T);
  const auto pair = scene.deepest_collision(mount_, joints_);
  ASSERT_TRUE(pair);
  EXPECT_NEAR(pair->depth, 0.0006, 1e-6);
  T.translation().z() -= 0.0007;
  scene.place(T);
  EXPECT_FALSE(scene.deepest_collision(mount_, joints_));
}

}  // namespace
}  // namespace palpate::simulation
