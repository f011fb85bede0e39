// SPDX-License-Identifier: Apache-2.0
#include "palpate/grasping/closing_trajectory.hpp"

#include <gtest/gtest.h>

#include "palpate/core/assets.hpp"
#include "palpate/hand/kinematics.hpp"
#include "palpate/hand/shadow.hpp"
#include "palpate/simulation/hand/load_hand.hpp"
#include "palpate/simulation/world/world.hpp"

namespace palpate::grasping {
namespace {

constexpr std::size_t kMiddle = static_cast<std::size_t>(hand::FingerName::middle);

class ClosingTrajectoryTest : public ::testing::Test {
 protected:
  ClosingTrajectoryTest() { mount_.translation().z() = 0.3; }
  ClosingTrajectory path(const hand::PerFinger<bool>& closing = kAllFingers) const {
    return closing_trajectory(model_, preshape_.open, law_, closing);
  }
  /// The box, with its centre where the middle finger's tip is half-way through its closing, and
  /// displaced from there.
  PlacedObject box_on_the_way(const ClosingTrajectory& path,
                              const Eigen::Vector3d& displaced = {0, 0, 0}) {
    const auto& shapes = path.fingers[kMiddle];
    Eigen::Isometry3d T = mount_;
    T.translation() +=
        mount_.linear() * shapes[shapes.size() / 2].tip.back().cast<double>() + displaced;
    return {box_, T, mount_};
  }

  hand::Description model_ = simulation::load_shadow_hand(asset("shadow_hand/right_hand.xml"));
  const hand::Preshape& preshape_ = model_.postures.top;
  ClosingLaw law_{model_, 1.0, preshape_.closed};
  geometry::ObjectModel box_{geometry::load_known_object("box")};
  Eigen::Isometry3d mount_ = Eigen::Isometry3d::Identity();
};

TEST_F(ClosingTrajectoryTest, FingersCloseFromTheOpenPosture) {
  for (const auto& shapes : path().fingers) {
    ASSERT_GT(shapes.size(), 20u);
    EXPECT_GT((shapes.front().tip.back() - shapes.back().tip.back()).norm(), 0.03f);
  }
}

TEST_F(ClosingTrajectoryTest, AFingertipsHullIsCoveredByItsPoints) {
  hand::Finger& finger = model_.fingers[kMiddle];
  finger.hull.emplace();
  finger.hull->radius = 0.001;
  for (int i = 0; i < 8; ++i) {
    finger.hull->core.emplace_back(i & 1 ? 0.006 : -0.006, i & 2 ? 0.005 : -0.005,
                                   i & 4 ? 0.026 : 0.002);
  }
  const ClosingTrajectory closing = path();
  EXPECT_EQ(closing.tip_radius[kMiddle], 0.001f);
  const auto T = hand::forward_kinematics(
      model_,
      hand::joints_in_free_flexion(model_, preshape_.open))[static_cast<std::size_t>(finger.link)];
  const auto& points = closing.fingers[kMiddle].front().tip;
  for (const Eigen::Vector3d& corner : finger.hull->core) {
    const Eigen::Vector3f placed = (T * corner).cast<float>();
    float nearest = 1;
    for (const auto& p : points) nearest = std::min(nearest, (p - placed).norm());
    EXPECT_LT(nearest, 0.001f) << "corners are points";
  }
  const Eigen::Vector3d end = T.inverse() * points.back().cast<double>();
  EXPECT_LT((end - finger.tip.b).norm(), 1e-6) << "the middle of its outer end comes last";
}

TEST_F(ClosingTrajectoryTest, OnlyTheFingersAskedForHaveShapes) {
  const ClosingTrajectory whole = path();
  const ClosingTrajectory one = path({false, false, true, false, false});
  for (std::size_t finger = 0; finger < hand::kShadowFingers; ++finger) {
    EXPECT_EQ(one.fingers[finger].empty(), finger != kMiddle);
  }
  EXPECT_EQ(one.open_spheres.size(), whole.open_spheres.size());
  const auto& shapes = one.fingers[kMiddle];  // others may take longer to close
  ASSERT_LE(shapes.size(), whole.fingers[kMiddle].size());
  for (std::size_t i = 0; i < shapes.size(); ++i) {
    EXPECT_EQ(shapes[i].tip.back(), whole.fingers[kMiddle][i].tip.back());
  }
}

TEST_F(ClosingTrajectoryTest, APathEndsBeforeItMeetsAnotherFinger) {
  const hand::PerFinger<bool> alone = {false, false, true, false, false};
  hand::ActuatorVector open = preshape_.open;
  const hand::JointVector others = hand::joints_in_free_flexion(model_, open);
  open[hand::shadow_hand().actuator("MFJ4")] = 0.35;  // over its neighbour
  const auto free = closing_trajectory(model_, preshape_.open, law_, alone);
  const auto crossing = closing_trajectory(model_, open, law_, alone);
  for (auto [path, blocked] : {std::pair(free, false), std::pair(crossing, true)}) {
    const std::size_t whole = path.fingers[kMiddle].size();
    end_at_other_fingers(model_, others, kMiddle, path);
    EXPECT_EQ(path.fingers[kMiddle].size() < whole, blocked);
  }
}

TEST_F(ClosingTrajectoryTest, AFingerStopsAtTheObjectWithItsTipOnTheSurface) {
  const ClosingTrajectory closing = path();
  // The tip reaches it before the links behind it do.
  for (const double ahead : {0.03, 0.04, 0.05}) {
    const auto& shapes = closing.fingers[kMiddle];
    const Eigen::Vector3d way =
        (shapes.back().tip.back() - shapes.front().tip.back()).cast<double>().normalized();
    const PlacedObject box = box_on_the_way(closing, ahead * way);
    const auto [stop, contact] = meet(box, closing, kMiddle, 0);
    if (!contact) continue;
    EXPECT_GT(stop, 0u);
    EXPECT_EQ(contact->finger, static_cast<int>(kMiddle));
    EXPECT_LT(std::abs(box.distance(contact->p.cast<float>())), 0.002f);  // the field's spacing
    EXPECT_NEAR(contact->n.norm(), 1, 1e-6);
    return;
  }
  FAIL() << "the tip met the box at none of three places on its way";
}

TEST_F(ClosingTrajectoryTest, AFingerThatMeetsNothingClosesToTheEnd) {
  const ClosingTrajectory closing = path();
  const PlacedObject box = box_on_the_way(closing, {0.5, 0, 0});
  const auto [stop, contact] = meet(box, closing, kMiddle, 0);
  EXPECT_FALSE(contact);
  EXPECT_EQ(stop + 1, closing.fingers[kMiddle].size());
}

TEST_F(ClosingTrajectoryTest, ATipThatMeetsTheTableStops) {
  mount_.translation().z() = 0;
  const ClosingTrajectory closing = path();
  const PlacedObject box = box_on_the_way(closing, {0.5, 0, 0});
  const auto [stop, contact] = meet(box, closing, kMiddle, 0.0025);
  EXPECT_FALSE(contact);
  EXPECT_LT(stop + 1, closing.fingers[kMiddle].size());
}

}  // namespace
}  // namespace palpate::grasping
