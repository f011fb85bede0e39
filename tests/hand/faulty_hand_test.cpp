// SPDX-License-Identifier: Apache-2.0
#include "palpate/hand/faulty_hand.hpp"

#include <gtest/gtest.h>

#include "hand/fake_hand.hpp"
#include "palpate/core/error.hpp"

namespace palpate::hand {
namespace {

void step_with(const FaultSchedule& fault) {
  FakeHand hand;
  FaultyHand faulty(hand, fault);
  faulty.step(resting_command());
  faulty.step(resting_command());
}

/// As the default indices are of a hand with fewer actuators than the Shadow hand.
TEST(FaultyHand, FaultsOfWhatTheHandHasNotAreRefused) {
  const Description model = shadow_hand();
  const int actuators = model.actuator_count(), joints = model.joint_count();
  EXPECT_NO_THROW(step_with({.fault = InjectedFault::joint_stuck, .actuator = actuators - 1}));
  EXPECT_THROW(step_with({.fault = InjectedFault::joint_stuck, .actuator = actuators}), BadInput);
  EXPECT_NO_THROW(step_with({.fault = InjectedFault::joint_nan, .joint = joints - 1}));
  EXPECT_THROW(step_with({.fault = InjectedFault::joint_nan, .joint = joints}), BadInput);
  for (const auto fault : {InjectedFault::finger_silent, InjectedFault::fingers_swapped}) {
    EXPECT_NO_THROW(step_with({.fault = fault, .finger = 4}));
    EXPECT_THROW(step_with({.fault = fault, .finger = 5}), BadInput);
    EXPECT_THROW(step_with({.fault = fault, .finger = -1}), BadInput);
  }
  EXPECT_NO_THROW(step_with({.fault = InjectedFault::load_nan, .finger = 7}));
}

}  // namespace
}  // namespace palpate::hand
