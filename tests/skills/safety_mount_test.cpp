// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "hand/fake_hand.hpp"
#include "palpate/hand/assembled_hand.hpp"
#include "palpate/hand/faulty_hand.hpp"
#include "palpate/hand/shadow.hpp"
#include "palpate/skills/executor.hpp"
#include "palpate/skills/safety.hpp"

namespace palpate::skills {
namespace {

using hand::InjectedFault;

constexpr double kFrom = 0.2;  // s at which a fault sets in
const hand::Description kSoftHand = hand::with_soft_actuators();

TEST(SafetyOfTheMount, AMountThatDoesNotFollowIsNamed) {
  hand::FakeHand fake;
  hand::FaultyHand faulty(fake, {.fault = InjectedFault::mount_stuck, .from = kFrom});
  Executor robot(faulty, kSoftHand, hand::resting_command());
  robot.wait(2 * kFrom);
  hand::MountPosition away = robot.command().mount;
  away.xyz.x() += 0.1;
  EXPECT_THROW(
      {
        robot.move_mount(away, 0.2);
        robot.wait(1);
      },
      SafetyStop);
  EXPECT_EQ(robot.fault().fault, Fault::joint_stuck);
  EXPECT_NE(robot.fault().detail.find("mount"), std::string::npos);
}

/// An arm that is where it is commanded to be, until it says nothing more.
struct SilencedArm : hand::Arm {
  std::string name() const override { return "lift"; }
  void move(const hand::MountPosition& to) override { target = to; }
  std::optional<hand::ArmReading> read() override {
    if (++reads > 20) return std::nullopt;
    const double ripple = reads % 2 == 0 ? 1e-12 : 0;
    return hand::ArmReading{target, {ripple, 0, 2}};
  }
  hand::MountPosition target;
  int reads = 0;
};

TEST(SafetyOfTheMount, AnArmThatSaysNothingMoreIsNamed) {
  hand::FakeHand fingers;
  SilencedArm arm;
  hand::AssembledHand hand(fingers, &arm, {});
  Executor robot(hand, kSoftHand, hand::resting_command());
  hand::MountPosition far;
  far.xyz.x() = 0.5;
  EXPECT_THROW(robot.move_mount(far, 0.05), SafetyStop);
  EXPECT_EQ(robot.fault().fault, Fault::silent);
  EXPECT_EQ(robot.fault().detail, "the arm 'lift': no new reading for 0.25 s");
  EXPECT_LT(arm.target.xyz.x(), 0.012);  // it was not moved on
}

}  // namespace
}  // namespace palpate::skills
