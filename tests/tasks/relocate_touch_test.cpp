// SPDX-License-Identifier: Apache-2.0
#include "palpate/tasks/relocate/relocate_touch.hpp"

#include <gtest/gtest.h>

#include <set>

#include "palpate/core/assets.hpp"
#include "palpate/simulation/hand/mjcf_hand.hpp"
#include "palpate/tasks/relocate/relocate_dynamics.hpp"

namespace palpate::relocate {
namespace {

simulation::SensorNoise no_noise() { return {0, 0, 0, 0, 0}; }

RelocateJoints random_joints(RandomStream& random) {
  RelocateJoints q = RelocateJoints::Zero();
  for (Eigen::Index i = 6; i < q.size(); ++i) q[i] = random.uniform(-0.4, 0.6);
  return q;
}

TEST(RelocateTouch, TheHandMovesAsTheSimulatorMovesIt) {
  const RelocateModel model(relocate_primitive_mug());
  const hand::Description hand = adroit_hand_model(model);
  simulation::MjcfHand oracle(asset("adroit_hand/adroit_relocate.xml"), "forearm");
  const std::vector<std::string> names = {"thdistal", "ffdistal", "mfdistal", "rfdistal",
                                          "lfdistal"};
  std::vector<hand::HandPoint> points;
  for (const auto& name : names) points.push_back(oracle.point(name));
  RandomStream random(4);
  for (int trial = 0; trial < 20; ++trial) {
    const RelocateJoints q = random_joints(random);
    Eigen::VectorXd below = q.tail(static_cast<Eigen::Index>(oracle.joint_names().size()));
    const Eigen::Matrix3d R_mount_forearm = hand.links.front().T_parent_link.linear();
    const Eigen::Matrix3Xd expected = R_mount_forearm * oracle.evaluate(below, points).positions;
    const auto T_mount_link = hand::forward_kinematics(hand, shadow_joints(q));
    for (std::size_t finger = 0; finger < names.size(); ++finger) {
      const auto link = static_cast<std::size_t>(hand.fingers[finger].link);
      EXPECT_EQ(hand.links[link].name, names[finger]);
      EXPECT_LT((T_mount_link[link].translation() - expected.col(static_cast<int>(finger))).norm(),
                1e-9);
    }
  }
}

TEST(RelocateTouch, SensesWhereItIs) {
  const RelocateModel model(relocate_primitive_mug());
  RelocateTask task(model);
  for (int step = 0; step < 20; ++step) task.step(RelocateAction::Constant(0.5));
  const RelocateTouch touch(model, no_noise(), 1);
  RelocateDynamics dynamics(model);
  const auto reading = touch.read(task, 0);
  const auto T_mount_link = hand::forward_kinematics(touch.hand_model(), reading.joints);
  const Eigen::Isometry3d T_world_palm =
      reading.mount.pose() * T_mount_link[static_cast<std::size_t>(touch.hand_model().palm)];
  const Eigen::Isometry3d expected = dynamics.palm(task.positions().head<kRelocateJoints>());
  EXPECT_LT((T_world_palm.matrix() - expected.matrix()).norm(), 1e-9);
  EXPECT_EQ(reading.time, 0);
}

TEST(RelocateTouch, NoiseIsOfTheSeedAndTheStepAlone) {
  const RelocateModel model(relocate_primitive_mug());
  const RelocateTask task(model);
  const RelocateTouch touch(model, {}, 5), same(model, {}, 5), other(model, {}, 6);
  EXPECT_EQ(touch.read(task, 3).joints, same.read(task, 3).joints);
  EXPECT_EQ(touch.read(task, 3).joints, touch.read(task, 3).joints);
  EXPECT_NE(touch.read(task, 3).joints, touch.read(task, 4).joints);
  EXPECT_NE(touch.read(task, 3).joints, other.read(task, 3).joints);
  const auto link = static_cast<std::size_t>(touch.hand_model().fingers[1].link);
  EXPECT_NE(touch.hand_model().links[link].T_parent_link.translation(),
            other.hand_model().links[link].T_parent_link.translation());
}

TEST(RelocateTouch, JointsGoToTheShadowHandAndBack) {
  RandomStream random(7);
  const RelocateJoints q = random_joints(random);
  EXPECT_EQ(task_joints(shadow_joints(q)), q);
}

TEST(RelocateTouch, EveryJointOfTheShadowHandHasItsTwin) {
  RelocateJoints q;
  for (Eigen::Index i = 0; i < q.size(); ++i) q[i] = 1.0 + static_cast<double>(i);
  std::set<double> seen;
  for (const double angle : shadow_joints(q)) seen.insert(std::abs(angle));
  EXPECT_EQ(seen.size(), 24u);        // each once
  EXPECT_GE(*seen.begin(), 1.0 + 6);  // none is of the base
}

}  // namespace
}  // namespace palpate::relocate
