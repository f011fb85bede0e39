// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "palpate/core/random.hpp"
#include "palpate/hand/kinematics.hpp"
#include "palpate/hand/shadow.hpp"

namespace palpate::hand {
namespace {

TEST(Coupling, MiddleJointGoesFirstThenBoth) {
  const CoupledAngles start = share_in_free_flexion(0.3);
  EXPECT_DOUBLE_EQ(start.j2, 0.3);
  EXPECT_DOUBLE_EQ(start.j1, 0.0);
  const CoupledAngles later = share_in_free_flexion(kShadowCoupling.follow_angle + 1.0);
  EXPECT_DOUBLE_EQ(later.j2, kShadowCoupling.follow_angle + 0.5);
  EXPECT_DOUBLE_EQ(later.j1, 0.5);
}

TEST(Coupling, ClosedMeansBothAtTheirEnds) {
  const double end = shadow_ranges()[static_cast<std::size_t>(joint_index("FFJ2"))].high;
  const CoupledAngles closed = share_in_free_flexion(2 * end);
  EXPECT_DOUBLE_EQ(closed.j2, end);
  EXPECT_DOUBLE_EQ(closed.j1, end);
}

TEST(Coupling, DistalNeverExceedsMiddleAndNeitherTurnsBack) {
  const double end = shadow_ranges()[static_cast<std::size_t>(joint_index("FFJ2"))].high;
  CoupledAngles before = share_in_free_flexion(0);
  for (double j0 = 0; j0 <= 2 * end; j0 += 0.01) {
    const CoupledAngles now = share_in_free_flexion(j0);
    EXPECT_LE(now.j1, now.j2 + 1e-12);
    EXPECT_LE(now.j2, end + 1e-12);
    EXPECT_GE(now.j1, before.j1 - 1e-12);
    EXPECT_GE(now.j2, before.j2 - 1e-12);
    before = now;
  }
}

TEST(Coupling, MiddleAngleTellsThePair) {
  for (double j2 = 0; j2 < 1.55; j2 += 0.05) {
    EXPECT_NEAR(share_in_free_flexion(j0_for_middle(j2)).j2, j2, 1e-12);
  }
}

TEST(Coupling, FreeFlexionInvertsActuatorPositions) {
  RandomStream random(3);
  for (int trial = 0; trial < 100; ++trial) {
    ActuatorVector positions;
    for (int i = 0; i < kActuators; ++i) positions[i] = random.uniform(0.0, 3.0);
    const JointVector joints = joints_in_free_flexion(positions);
    EXPECT_LT((actuator_positions(joints) - positions).norm(), 1e-12);
  }
}

}  // namespace
}  // namespace palpate::hand
