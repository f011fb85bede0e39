// SPDX-License-Identifier: Apache-2.0
#include "skills/grasp/pressing.hpp"

#include <gtest/gtest.h>

#include "grasping/coupled_finger.hpp"
#include "hand/fake_hand.hpp"

namespace palpate::skills {
namespace {

using grasping::contact;
using grasping::coupled_finger;

TEST(PressingCommand, LeadsByTorqueOverStiffnessWithinTheRange) {
  const auto model = hand::with_soft_actuators(coupled_finger());
  hand::FakeHand hand([](hand::HandReading& reading) {
    reading.torques[hand::shadow_hand().actuator("FFJ0")] = 0.03;
    reading.torques[hand::shadow_hand().actuator("MFJ0")] = 0.2;
    reading.joints[hand::shadow_hand().joint("FFJ1")] =
        reading.joints[hand::shadow_hand().joint("FFJ2")] = 0;
  });
  hand::HandCommand start = hand::resting_command();
  start.positions.setConstant(0.4);
  Executor robot(hand, model, start);
  robot.wait(hand::kTick);
  const std::vector contacts = {contact({0.05, 0, 0}, {0, -1, 0})};
  for (const auto& [force, expected] : {std::pair(2.0, 0.4 + 0.07 - 0.03), std::pair(1e3, 3.2)}) {
    const std::vector<Eigen::Vector3d> forces = {{0, force, 0}};
    const auto command = pressing_command(robot, contacts, forces);
    EXPECT_NEAR(command[hand::shadow_hand().actuator("FFJ0")], expected,
                1e-9);                                              // stiffness 1 N m/rad
    EXPECT_EQ(command[hand::shadow_hand().actuator("MFJ0")], 0.4);  // it presses on nothing
  }
}

TEST(WeightAt, PullsDownAtTheCentreInTheTurnedMountsFrame) {
  const auto model = hand::with_soft_actuators(coupled_finger());
  hand::FakeHand hand;
  hand::HandCommand start = hand::resting_command();
  start.mount.xyz = {0.1, 0.2, 0.3};
  start.mount.ypr = {0.4, 0.7, -0.3};
  Executor robot(hand, model, start);
  robot.wait(hand::kTick);
  const Eigen::Isometry3d T_world_mount = start.mount.pose();
  Eigen::Isometry3d T_world_object = Eigen::Isometry3d::Identity();
  T_world_object.translation() << 0.05, -0.02, 0.04;
  const grasping::Load load = weight_at(robot, T_world_object, 2.5);
  EXPECT_LT((T_world_mount * load.point - T_world_object.translation()).norm(), 1e-12);
  EXPECT_LT((T_world_mount.linear() * load.force - Eigen::Vector3d(0, 0, -2.5)).norm(), 1e-12);
}

}  // namespace
}  // namespace palpate::skills
