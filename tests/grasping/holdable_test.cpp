// SPDX-License-Identifier: Apache-2.0
#include "palpate/grasping/holdable.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "palpate/core/error.hpp"
#include "palpate/geometry/objects/shapes.hpp"
#include "palpate/skills/grasp/grasp_phase.hpp"
#include "skills/soft_shadow.hpp"

namespace palpate::grasping {
namespace {

geometry::ObjectModel cube(double side, double mass) {
  return geometry::ObjectModel(
      geometry::make_known_object("cube", geometry::box_mesh({side, side, side}), mass));
}

std::string refusal(const geometry::ObjectModel& object) {
  return why_not_holdable(object, skills::soft_shadow(), skills::pressure({}, object.object()));
}

TEST(LeastWidth, IsTheThinnestThatAFingerFindsFromTheSide) {
  EXPECT_NEAR(min_width(geometry::load_known_object("box")), 0.050, 1e-4);
  EXPECT_NEAR(min_width(geometry::load_known_object("bracket")), 0.020, 1e-4);
  EXPECT_LT(min_width(geometry::load_known_object("mug")), 0.006) << "its wall";
}

TEST(LeastWidth, IsNotTheThicknessOfAPlateThatOnlyLies) {
  auto plate = geometry::make_known_object("plate", geometry::box_mesh({0.2, 0.15, 0.01}), 0.3);
  std::erase_if(plate.stable_poses, [](const auto& stable_pose) {
    return std::abs(stable_pose.R_table_object(2, 2)) < 0.9;
  });
  EXPECT_NEAR(min_width(plate), 0.15, 1e-4);
}

TEST(Opening, OfTheShadowHandIsSomeFifteenToTwentyCentimetres) {
  EXPECT_GT(opening(skills::soft_shadow()), 0.12);
  EXPECT_LT(opening(skills::soft_shadow()), 0.22);
}

TEST(GreatestPress, IsThatOfTheThumbTwiceWhereTheOthersAreStronger) {
  hand::Description hand = skills::soft_shadow();
  const double press = greatest_press(hand);
  EXPECT_GT(press, 5);
  for (hand::Actuator& actuator : hand.actuators) {
    if (actuator.finger == hand.thumb) actuator.max_torque *= 0.5;
  }
  EXPECT_NEAR(greatest_press(hand), 0.5 * press, 1e-9);
}

TEST(WhyNotHoldable, NamesWhatIsTooWide) {
  EXPECT_EQ(refusal(cube(0.05, 0.2)), "");
  EXPECT_EQ(refusal(cube(0.10, 0.4)), "");
  EXPECT_NE(refusal(cube(0.15, 0.4)).find("too wide: 150 mm"), std::string::npos);
  EXPECT_NE(refusal(cube(0.25, 0.4)).find("too wide: 250 mm"), std::string::npos);
}

TEST(WhyNotHoldable, NamesWhatIsTooHeavy) {
  EXPECT_EQ(refusal(cube(0.05, 1.5)), "");
  EXPECT_NE(refusal(cube(0.05, 3.0)).find("too heavy: it weighs 29.4 N"), std::string::npos);
}

/// What is only heavy is pressed harder, not too wide.
TEST(WhyNotHoldable, CountsOnThePressOfThePick) {
  const auto hand = simulation::load_shadow_hand(asset("shadow_hand/right_hand.xml"));
  const auto heavy = cube(0.10, 0.8);
  EXPECT_NE(why_not_holdable(heavy, hand, 6).find("too wide: 100 mm"), std::string::npos);
  EXPECT_EQ(why_not_holdable(heavy, hand, skills::pressure({}, heavy.object())), "");
}

TEST(WhyNotHoldable, NeedsTheHandsLinks) {
  EXPECT_THROW(static_cast<void>(why_not_holdable(cube(0.05, 0.2), hand::shadow_hand(), 6)),
               BadInput);
}

TEST(WhyNotHoldable, RefusesNoBuiltInObject) {
  for (const char* name : {"mug", "bottle", "box", "bracket", "duck"}) {
    EXPECT_EQ(refusal(geometry::ObjectModel(geometry::load_known_object(name))), "") << name;
  }
}

}  // namespace
}  // namespace palpate::grasping
