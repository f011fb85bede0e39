// SPDX-License-Identifier: Apache-2.0
#include "palpate/tasks/relocate/relocate_dynamics.hpp"

#include <gtest/gtest.h>

#include "palpate/core/random.hpp"
#include "palpate/core/se3.hpp"

namespace palpate::relocate {
namespace {

RelocateModel fast_model() {
  return RelocateModel(relocate_primitive_mug(), {RelocateSolver::fast, 1, 1});
}

TEST(RelocateDynamics, PlacesThePalmWhereItIsWanted) {
  RelocateDynamics dynamics(fast_model());
  RandomStream random(4);
  for (int trial = 0; trial < 20; ++trial) {
    Eigen::Isometry3d T = dynamics.palm(RelocateJoints::Zero());
    T.translation() += Eigen::Vector3d(0, 0.1, 0.05) + 0.03 * random.normal3();
    T.linear() = exp_so3(0.1 * random.unit_vector()) * T.linear();
    const auto q = dynamics.place_palm(T, RelocateDynamics::FingerJoints::Zero());
    if ((q - dynamics.lower()).minCoeff() <= 0 &&
        (q.head<6>() - dynamics.lower().head<6>()).minCoeff() <= 0) {
      continue;  // out of the base's reach
    }
    const Eigen::Isometry3d there = dynamics.palm(q);
    EXPECT_LT((there.translation() - T.translation()).norm(), 1e-9);
    EXPECT_LT(rotation_distance(there.linear(), T.linear()), 1e-9);
  }
}

TEST(RelocateDynamics, TorquesHoldTheHandStill) {
  const auto model = fast_model();
  RelocateDynamics dynamics(model);
  RelocateTask task(model);
  task.reset({{0.05, 0.1}, {0, 0, 0.2}});
  // Within all ranges by a margin, so that no limit helps.
  RelocateJoints q = (dynamics.lower() + dynamics.upper()) / 2;
  const auto action =
      dynamics.action(q, RelocateJoints::Zero(),
                      dynamics.torques(q, RelocateJoints::Zero(), RelocateJoints::Zero()));
  ASSERT_LT(action.cwiseAbs().maxCoeff(), 1.2);
  for (int i = 0; i < 400; ++i) task.step(action);
  // Friction in the joints (0.001 N m against 1 N m/rad) leaves a milliradian; sag would be 24 cm.
  EXPECT_LT((task.observation().head<30>() - q).head<6>().cwiseAbs().maxCoeff(), 0.01);
}

TEST(RelocateDynamics, AnActionExertsTheTorquesItIsMadeOf) {
  const auto model = fast_model();
  RelocateDynamics dynamics(model);
  RelocateTask task(model);
  // From rest, the base accelerates as the torques say.
  RelocateJoints acceleration = RelocateJoints::Zero();
  acceleration[2] = 2;  // m/s^2 along the arm
  const auto zero = RelocateJoints::Zero();
  const auto action = dynamics.action(zero, zero, dynamics.torques(zero, zero, acceleration));
  task.step(action);
  EXPECT_NEAR(task.proprioception().velocity[2], 0.02, 0.002);
}

TEST(RelocateDynamics, ALoadWeighsWhatItWeighs) {
  RelocateDynamics dynamics(fast_model());
  const auto zero = RelocateJoints::Zero();
  const RelocateJoints added =
      dynamics.torques(zero, zero, zero, 0.5) - dynamics.torques(zero, zero, zero);
  // The hand's file writes right angles as 1.57, so its axes are tilted by 1.6 mrad.
  EXPECT_NEAR(added[1], 0.5 * 9.81, 1e-4);  // the joint that lifts
  EXPECT_NEAR(added[0], 0, 0.0017 * 0.5 * 9.81);
}

TEST(RelocateDynamics, PressingMovesNoArm) {
  RelocateDynamics dynamics(fast_model());
  const auto q = RelocateJoints::Zero();
  const auto torques = dynamics.press(q, dynamics.palm(q) * Eigen::Vector3d(0, -0.06, 0.09), 2);
  EXPECT_EQ(torques.head<8>().norm(), 0);
  EXPECT_GT(torques[9], 0.01);  // the first finger flexes
}

}  // namespace
}  // namespace palpate::relocate
