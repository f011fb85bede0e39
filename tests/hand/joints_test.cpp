// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "palpate/core/error.hpp"
#include "palpate/hand/shadow.hpp"

namespace palpate::hand {
namespace {

TEST(Joints, NamesMapToIndicesAndBack) {
  for (int i = 0; i < kJoints; ++i) {
    EXPECT_EQ(joint_index(kJointNames[static_cast<std::size_t>(i)]), i);
  }
  for (int i = 0; i < kActuators; ++i) {
    EXPECT_EQ(actuator_index(kActuatorNames[static_cast<std::size_t>(i)]), i);
  }
  EXPECT_THROW(joint_index("FFJ0"), BadInput);
  EXPECT_THROW(actuator_index("FFJ1"), BadInput);
}

TEST(Joints, CoupledActuatorsReadTheSumOfTheirPair) {
  JointVector joints;
  for (int i = 0; i < kJoints; ++i) joints[i] = 1 << i;
  const ActuatorVector positions = actuator_positions(joints);
  for (std::string_view name : kActuatorNames) {
    const auto finger = std::string(name.substr(0, 3));
    const double expected =
        name.back() == '0' ? joints[joint_index(finger + "2")] + joints[joint_index(finger + "1")]
                           : joints[joint_index(name)];
    EXPECT_EQ(positions[actuator_index(name)], expected) << name;
  }
}

TEST(Joints, RangesOfTableA1) {
  const auto& ranges = shadow_ranges();
  const auto range = [&](std::string_view name) {
    return ranges[static_cast<std::size_t>(joint_index(name))];
  };
  EXPECT_DOUBLE_EQ(range("WRJ2").low, -0.489);
  EXPECT_DOUBLE_EQ(range("THJ4").high, 1.222);
  EXPECT_DOUBLE_EQ(range("RFJ4").low, -0.349);
  EXPECT_DOUBLE_EQ(range("MFJ3").low, -0.262);
  EXPECT_DOUBLE_EQ(range("LFJ1").low, 0.0);
  EXPECT_DOUBLE_EQ(range("LFJ5").high, 0.785);
  for (const Range& r : ranges) EXPECT_LT(r.low, r.high);
  for (const HumanRange& human : kHumanRanges) EXPECT_LT(human.range.low, human.range.high);
}

TEST(Joints, FingersOfActuators) {
  EXPECT_EQ(finger_of_actuator(actuator_index("WRJ1")), -1);
  EXPECT_EQ(finger_of_actuator(actuator_index("THJ5")), 0);
  EXPECT_EQ(finger_of_actuator(actuator_index("LFJ5")), 4);
}

}  // namespace
}  // namespace palpate::hand
