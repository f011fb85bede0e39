// SPDX-License-Identifier: Apache-2.0
#include "hand/finger_reading.hpp"

#include <gtest/gtest.h>

namespace palpate::hand {
namespace {

HandReading numbered() {
  HandReading reading;
  reading.time = 0.25;
  for (int i = 0; i < kJoints; ++i) reading.joints[i] = i;
  for (int i = 0; i < kActuators; ++i) reading.torques[i] = 100 + i;
  reading.contacts[4].push_back({{1, 2, 3}, {0, 0, 1}, {0, 0, -1}});
  return reading;
}

TEST(FingerReading, HasTheFingersOwnJointsDrivesAndContacts) {
  const HandReading hand = numbered();
  const FingerReading little = finger_reading(hand, Finger::little);
  EXPECT_EQ(little.time, 0.25);
  ASSERT_EQ(little.joints.size(), 5u);
  EXPECT_EQ(little.joints.front().name, "LFJ5");
  EXPECT_EQ(little.joints.back().name, "LFJ1");
  EXPECT_EQ(little.joints.back().angle, joint_index("LFJ1"));
  ASSERT_EQ(little.drives.size(), 4u);
  EXPECT_EQ(little.drives.back().name, "LFJ0");
  EXPECT_EQ(little.drives.back().torque, 100 + actuator_index("LFJ0"));
  EXPECT_EQ(little.contacts.size(), 1u);
  EXPECT_TRUE(finger_reading(hand, Finger::thumb).contacts.empty());
}

TEST(FingerReading, FingersAndWristShareAllJointsAndDrives) {
  const HandReading hand = numbered();
  std::size_t joints = wrist_reading(hand).joints.size();
  std::size_t drives = wrist_reading(hand).drives.size();
  EXPECT_EQ(joints, 2u);
  EXPECT_EQ(drives, 2u);
  for (int i = 0; i < kFingers; ++i) {
    joints += finger_reading(hand, static_cast<Finger>(i)).joints.size();
    drives += finger_reading(hand, static_cast<Finger>(i)).drives.size();
  }
  EXPECT_EQ(joints, static_cast<std::size_t>(kJoints));
  EXPECT_EQ(drives, static_cast<std::size_t>(kActuators));
}

}  // namespace
}  // namespace palpate::hand
