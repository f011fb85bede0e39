// SPDX-License-Identifier: Apache-2.0
#include "palpate/hand/description.hpp"

#include <gtest/gtest.h>

#include "core/error_message.hpp"
#include "hand/descriptions.hpp"
#include "palpate/core/error.hpp"
#include "palpate/hand/kinematics.hpp"

namespace palpate::hand {
namespace {

TEST(Description, NamesMapToIndicesAndBack) {
  const Description& hand = shadow_hand();
  ASSERT_EQ(hand.joint_count(), kShadowJoints);
  ASSERT_EQ(hand.actuator_count(), kShadowActuators);
  ASSERT_EQ(hand.finger_count(), kShadowFingers);
  for (int i = 0; i < kShadowJoints; ++i) {
    EXPECT_EQ(hand.joint(kShadowJointNames[static_cast<std::size_t>(i)]), i);
  }
  for (int i = 0; i < kShadowActuators; ++i) {
    EXPECT_EQ(hand.actuator(kShadowActuatorNames[static_cast<std::size_t>(i)]), i);
  }
}

TEST(Description, UnknownNamesAreNamed) {
  const Description& hand = shadow_hand();
  EXPECT_NE(error_message([&] { (void)hand.joint("FFJ0"); }).find("joint named 'FFJ0'"),
            std::string::npos);
  EXPECT_NE(error_message([&] { (void)hand.actuator("FFJ1"); }).find("actuator named 'FFJ1'"),
            std::string::npos);
  EXPECT_THROW((void)Description().joint(""), BadInput);
}

TEST(Description, CoupledActuatorsReadTheSumOfTheirPair) {
  const Description& hand = shadow_hand();
  JointVector joints(kShadowJoints);
  for (int i = 0; i < kShadowJoints; ++i) joints[i] = 1 << i;
  const ActuatorVector positions = actuator_positions(hand, joints);
  for (std::string_view name : kShadowActuatorNames) {
    const auto finger = std::string(name.substr(0, 3));
    const double expected =
        name.back() == '0' ? joints[hand.joint(finger + "2")] + joints[hand.joint(finger + "1")]
                           : joints[hand.joint(name)];
    EXPECT_EQ(positions[hand.actuator(name)], expected) << name;
  }
}

TEST(Description, RangesOfTableA1) {
  const auto range = [](std::string_view name) {
    const Description& hand = shadow_hand();
    return hand.joints[static_cast<std::size_t>(hand.joint(name))].range;
  };
  EXPECT_DOUBLE_EQ(range("WRJ2").low, -0.489);
  EXPECT_DOUBLE_EQ(range("THJ4").high, 1.222);
  EXPECT_DOUBLE_EQ(range("RFJ4").low, -0.349);
  EXPECT_DOUBLE_EQ(range("MFJ3").low, -0.262);
  EXPECT_DOUBLE_EQ(range("LFJ1").low, 0.0);
  EXPECT_DOUBLE_EQ(range("LFJ5").high, 0.785);
  for (const Joint& joint : shadow_hand().joints) EXPECT_LT(joint.range.low, joint.range.high);
  for (const HumanRange& human : kHumanRanges) EXPECT_LT(human.range.low, human.range.high);
}

TEST(Description, FingersOfActuators) {
  const Description& hand = shadow_hand();
  const auto finger_of = [&](std::string_view name) {
    return hand.actuators[static_cast<std::size_t>(hand.actuator(name))].finger;
  };
  EXPECT_EQ(finger_of("WRJ1"), -1);
  EXPECT_EQ(finger_of("THJ5"), 0);
  EXPECT_EQ(finger_of("LFJ5"), 4);
}

TEST(Description, TheMiddleFingerIsThatOfTheOthersThanTheThumb) {
  EXPECT_EQ(shadow_hand().middle_finger(), static_cast<int>(FingerName::middle));
  EXPECT_EQ(two_finger_hand().middle_finger(), 1);
  Description three = two_finger_hand();
  three.fingers.push_back(three.fingers[1]);
  three.thumb = 1;
  EXPECT_EQ(three.middle_finger(), 0);
  Description one = two_finger_hand();
  one.fingers.pop_back();
  EXPECT_EQ(one.middle_finger(), one.thumb);
}

TEST(Description, ClosingActuatorsGoFromThePalmOutwards) {
  const Description& hand = shadow_hand();
  const auto names = [&](FingerName finger) {
    std::vector<std::string> result;
    for (const int i : closing_actuators(hand, static_cast<int>(finger))) {
      result.push_back(hand.actuators[static_cast<std::size_t>(i)].name);
    }
    return result;
  };
  EXPECT_EQ(names(FingerName::thumb), (std::vector<std::string>{"THJ5", "THJ2", "THJ1"}));
  EXPECT_EQ(names(FingerName::little), (std::vector<std::string>{"LFJ3", "LFJ0"}));
  EXPECT_EQ(closing_actuators(two_finger_hand(), 0), std::vector{0});  // of negative speed
  EXPECT_TRUE(closing_actuators(hand, kShadowFingers).empty());
}

TEST(Description, TheSpreadingActuatorComesLastBeforeThoseThatClose) {
  const Description& hand = shadow_hand();
  EXPECT_EQ(spreading_actuator(hand, static_cast<int>(FingerName::first)), hand.actuator("FFJ4"));
  EXPECT_EQ(spreading_actuator(hand, static_cast<int>(FingerName::little)), hand.actuator("LFJ4"));
  EXPECT_FALSE(spreading_actuator(hand, static_cast<int>(FingerName::thumb)));
  EXPECT_FALSE(spreading_actuator(two_finger_hand(), 1));
}

}  // namespace
}  // namespace palpate::hand
