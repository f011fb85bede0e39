// SPDX-License-Identifier: Apache-2.0
#include "palpate/skills/finger_trust.hpp"

#include <gtest/gtest.h>

#include "hand/fake_hand.hpp"
#include "palpate/skills/executor.hpp"

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

}  // namespace
}  // namespace palpate::skills
