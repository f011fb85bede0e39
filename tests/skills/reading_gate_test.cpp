// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "hand/fake_hand.hpp"
#include "palpate/skills/executor.hpp"
#include "skills/soft_shadow.hpp"

namespace palpate::skills {
namespace {

using hand::HandReading;
using hand::kTick;

/// Number of a fingertip's contacts that are left of one that touches so.
std::size_t left_of(const hand::TipContact& contact) {
  hand::FakeHand hand([&](HandReading& reading) { reading.contacts[1] = {contact}; },
                      soft_shadow());
  Executor robot(hand, soft_shadow(), hand::resting_command());
  robot.wait(0.1);
  return robot.reading().contacts[1].size();
}

TEST(ReadingGate, DropsContactsThatAreFarFromTheirFingertip) {
  const Eigen::Vector3d up = Eigen::Vector3d::UnitZ();
  EXPECT_EQ(left_of({0.02 * up, up, -up}), 1u);
  EXPECT_EQ(left_of({0.09 * up, up, -up}), 1u);  // models of fingertips are not exact
  for (const double way : {0.5, 26.5, 1e200}) EXPECT_EQ(left_of({way * up, up, -up}), 0u) << way;
}

TEST(ReadingGate, DropsContactsWhoseNormalIsNoUnitVector) {
  const Eigen::Vector3d up = Eigen::Vector3d::UnitZ();
  for (const double length : {0.0, 0.95, 1.05}) {
    EXPECT_EQ(left_of({0.02 * up, length * up, -up}), 1u) << length;
  }
  for (const double length : {0.3, 5.0}) {
    EXPECT_EQ(left_of({0.02 * up, length * up, -up}), 0u) << length;
  }
}

FaultReport fault_while_waiting(hand::FakeHand::Script script, double seconds) {
  hand::FakeHand hand(std::move(script), soft_shadow());
  Executor robot(hand, soft_shadow(), hand::resting_command());
  EXPECT_THROW(robot.wait(seconds), SafetyStop);
  return robot.fault();
}

TEST(ReadingGate, AMountThatDriftsAwayIsNamed) {
  const FaultReport fault = fault_while_waiting(
      [](HandReading& reading) { reading.mount.xyz.x() += 0.005 * reading.time; }, 60);
  EXPECT_EQ(fault.fault, Fault::joint_stuck);
  EXPECT_TRUE(fault.detail.starts_with("the mount moves")) << fault.detail;
  EXPECT_NEAR(fault.time, 0.05 / 0.005 + 4 * SafetyOptions{}.tracking_time, 0.05);
}

TEST(ReadingGate, AJointThatKeepsMovingOffItsCommandIsNamed) {
  const int knuckle = soft_shadow().joint("FFJ3");
  const FaultReport fault = fault_while_waiting(
      [knuckle](HandReading& reading) { reading.joints[knuckle] += 0.25 * reading.time; }, 20);
  EXPECT_EQ(fault.fault, Fault::joint_stuck);
  EXPECT_TRUE(fault.detail.starts_with("FFJ3 moves at")) << fault.detail;
}

TEST(ReadingGate, ASlowClockIsNamed) {
  const FaultReport fault =
      fault_while_waiting([](HandReading& reading) { reading.time *= 0.996; }, 60);
  EXPECT_EQ(fault.fault, Fault::late);
  EXPECT_NE(fault.detail.find("the hand's clock went on by 1"), std::string::npos) << fault.detail;
}

}  // namespace
}  // namespace palpate::skills
