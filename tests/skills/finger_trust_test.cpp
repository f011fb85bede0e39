// SPDX-License-Identifier: Apache-2.0
#include "palpate/skills/finger_trust.hpp"

#include <gtest/gtest.h>

#include "hand/fake_hand.hpp"
#include "palpate/skills/executor.hpp"
#include "skills/explore/table_press.hpp"

namespace palpate::skills {
namespace {

TEST(FingerTrust, AllAreTrustedAndNoneSuspectedAtFirst) {
  const FingerTrust trust;
  EXPECT_TRUE(trust.trusted(0));
  EXPECT_TRUE(trust.suspects().empty());
}

TEST(FingerTrust, AFingerThatWasClearedIsNotSuspectedAgain) {
  FingerTrust trust;
  trust.suspect(2);
  trust.suspect(1);
  EXPECT_EQ(trust.suspects(), (std::vector<int>{1, 2}));
  trust.clear(1);
  trust.suspect(1);
  EXPECT_EQ(trust.suspects(), std::vector<int>{2});
}

TEST(FingerTrust, AFingerThatIsDistrustedIsSuspectedNoMoreAndOneFault) {
  hand::FakeHand hand;
  Executor robot(hand, hand::shadow_hand(), hand::resting_command());
  robot.trust().suspect(2);
  for (int i = 0; i < 2; ++i) robot.distrust(2, "senses nothing");
  EXPECT_FALSE(robot.trust().trusted(2));
  EXPECT_FALSE(robot.trust().suspected(2));
  EXPECT_EQ(robot.survived().size(), 1U);
}

TEST(FingerTrust, SwappedFingertipsGetEachOthersContacts) {
  const Eigen::Vector3d up = Eigen::Vector3d::UnitZ();
  hand::FakeHand hand([&](hand::HandReading& reading) {
    reading.contacts[1] = {{0.01 * up, up, -2 * up}};
  });
  Executor robot(hand, hand::shadow_hand(), hand::resting_command());
  robot.wait(0.1);
  robot.swap_touch(1, 2);  // the first of a cycle of three
  robot.wait(0.1);
  EXPECT_TRUE(robot.reading().contacts[1].empty());
  EXPECT_FALSE(robot.reading().contacts[2].empty());
  robot.swap_touch(2, 3);
  robot.wait(0.1);
  EXPECT_TRUE(robot.reading().contacts[2].empty());
  EXPECT_FALSE(robot.reading().contacts[3].empty());
  ASSERT_EQ(robot.survived().size(), 2U);
  EXPECT_EQ(robot.survived()[0].detail, "MF reports what FF touches, and FF what MF touches");
}

TEST(UnsensedPresses, OnlyWhereEachReportsTheOthersAreTwoFingertipsSwapped) {
  UnsensedPresses presses;
  for (int i = 0; i < 2; ++i) presses.add(1, {true, 2});
  EXPECT_FALSE(presses.swapped_with(1, 2)) << "2 may merely touch, too";
  for (int i = 0; i < 2; ++i) presses.add(2, {true, 2});
  EXPECT_FALSE(presses.swapped_with(1, 2)) << "2 senses for itself";
  for (int i = 0; i < 2; ++i) presses.add(2, {true, 1});
  EXPECT_EQ(presses.swapped_with(1, 2), 2);
  EXPECT_EQ(presses.swapped_with(2, 2), 1);
  presses.add(1, {true, std::nullopt});
  EXPECT_FALSE(presses.swapped_with(1, 2));
  EXPECT_EQ(presses.count(1), 3);
}

}  // namespace
}  // namespace palpate::skills
