// SPDX-License-Identifier: Apache-2.0
#include "palpate/simulation/hand/integral_action.hpp"

#include <gtest/gtest.h>

#include "palpate/hand/shadow.hpp"

namespace palpate::simulation {
namespace {

hand::ActuatorVector all(double value) {
  return hand::ActuatorVector::Constant(hand::kShadowActuators, value);
}

const hand::ActuatorVector kStiffness = all(2);

TEST(IntegralAction, EqualsTheProportionalPartAfterItsTime) {
  IntegralAction integral({.time = 0.5, .limit = 1, .deadband = 0});
  hand::ActuatorVector torque;
  for (int i = 0; i < 250; ++i) {
    torque = integral.update(all(0.05), kStiffness, 0.002);
  }
  EXPECT_NEAR(torque[4], 2 * 0.05, 1e-12);
  EXPECT_NEAR(torque[19], 2 * 0.05, 1e-12);
}

TEST(IntegralAction, DoesNotWindUp) {
  IntegralAction integral({.time = 0.5, .limit = 0.03, .deadband = 0});
  for (int i = 0; i < 5000; ++i) integral.update(all(1), kStiffness, 0.002);
  EXPECT_DOUBLE_EQ(integral.update(all(1), kStiffness, 0.002)[0], 0.03);
  hand::ActuatorVector torque;
  for (int i = 0; i < 20; ++i) {
    torque = integral.update(-all(1), kStiffness, 0.002);
  }
  EXPECT_DOUBLE_EQ(torque[0], -0.03);
}

TEST(IntegralAction, LetsSmallErrorsBeAndForgetsOnReset) {
  IntegralAction integral({.time = 0.5, .limit = 0.03, .deadband = 0.004});
  EXPECT_EQ(integral.update(all(0.004), kStiffness, 0.002).norm(), 0);
  EXPECT_GT(integral.update(all(-0.005), kStiffness, 0.002).norm(), 0);
  integral.reset();
  EXPECT_EQ(integral.update(all(0), kStiffness, 0.002).norm(), 0);
}

}  // namespace
}  // namespace palpate::simulation
