// SPDX-License-Identifier: Apache-2.0
#include "palpate/skills/release/withdraw_phase.hpp"

#include <gtest/gtest.h>

#include "hand/fake_hand.hpp"
#include "palpate/hand/shadow.hpp"

namespace palpate::skills {
namespace {

constexpr double kHeldWeight = 2.0;  // N

PhaseReport withdrawn(hand::FakeHand::Script script) {
  hand::FakeHand hand(std::move(script));
  const hand::Description model = hand::with_soft_actuators();
  hand::HandCommand command = hand::resting_command();
  command.mount.xyz.z() = 0.1;
  command.positions.setConstant(0.5);
  Executor robot(hand, model, command);
  PickState state;
  WithdrawPhase phase({}, kHeldWeight);
  return run_phase(phase, robot, state);
}

TEST(WithdrawPhase, RisesFree) { EXPECT_EQ(withdrawn({}).status, PhaseStatus::ok); }

TEST(WithdrawPhase, OpensWiderWhereItIsCaught) {
  const int finger = hand::shadow_hand().joint("FFJ3");
  const auto report = withdrawn([&](hand::HandReading& reading) {
    const bool caught = reading.joints[finger] > 0.4 && reading.mount.xyz.z() > 0.12;
    reading.mount_force.z() = caught ? 1.0 : 0.0;
  });
  EXPECT_EQ(report.status, PhaseStatus::ok) << report.outcome;
  EXPECT_NE(report.outcome.find("2 tries"), std::string::npos) << report.outcome;
}

TEST(WithdrawPhase, AnObjectThatComesAlongIsAFailure) {
  const auto report =
      withdrawn([](hand::HandReading& reading) { reading.mount_force.z() = kHeldWeight; });
  EXPECT_EQ(report.status, PhaseStatus::failed);
  EXPECT_NE(report.outcome.find("hang"), std::string::npos);
}

}  // namespace
}  // namespace palpate::skills
