// SPDX-License-Identifier: Apache-2.0
#include "palpate/hand/kinematics.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "palpate/core/random.hpp"
#include "palpate/core/se3.hpp"
#include "palpate/hand/hand.hpp"
#include "palpate/hand/nearest_mount.hpp"
#include "palpate/hand/shadow.hpp"
#include "palpate/hand/tip_forces.hpp"

namespace palpate::hand {
namespace {

/// Two hinges in a row, 0.1 m apart, and a fixed tip.
Description planar_arm() {
  Description hand;
  hand.joints.resize(2);
  hand.links.resize(3);
  for (int i = 0; i < 3; ++i) {
    Link& link = hand.links[static_cast<std::size_t>(i)];
    link.parent = i - 1;
    link.joint = i < 2 ? i : -1;
    link.axis = Eigen::Vector3d::UnitZ();
    if (i > 0) link.T_parent_link.translation() = Eigen::Vector3d(0.1, 0, 0);
  }
  return hand;
}

Description random_chain(RandomStream& random) {
  Description hand;
  hand.joints.resize(6);
  hand.links.resize(6);
  for (int i = 0; i < 6; ++i) {
    Link& link = hand.links[static_cast<std::size_t>(i)];
    link.parent = i - 1;
    link.joint = i;
    link.axis = random.unit_vector();
    link.T_parent_link.linear() = random.rotation();
    link.T_parent_link.translation() = 0.05 * random.normal3();
  }
  return hand;
}

TEST(Kinematics, PlanarArm) {
  JointVector joints = JointVector::Zero(2);
  joints[0] = M_PI / 2;
  joints[1] = -M_PI / 2;
  const auto T = forward_kinematics(planar_arm(), joints);
  EXPECT_TRUE(T[2].translation().isApprox(Eigen::Vector3d(0.1, 0.1, 0), 1e-12));
  EXPECT_TRUE(T[2].linear().isApprox(Eigen::Matrix3d::Identity(), 1e-12));
}

TEST(Kinematics, JacobianIsTheDerivativeOfThePose) {
  RandomStream random(3, "jacobian");
  for (int trial = 0; trial < 20; ++trial) {
    const Description hand = random_chain(random);
    JointVector joints(hand.joint_count());
    for (double& joint : joints) joint = random.uniform(-1.5, 1.5);
    const Eigen::Vector3d p_link = 0.02 * random.normal3();
    const auto J = jacobian(hand, joints, 5, p_link);
    const auto T0 = forward_kinematics(hand, joints)[5];
    for (int i = 0; i < 6; ++i) {
      JointVector moved = joints;
      moved[i] += 1e-6;
      const auto T1 = forward_kinematics(hand, moved)[5];
      const Eigen::Vector3d w = log_so3(T1.linear() * T0.linear().transpose()) / 1e-6;
      const Eigen::Vector3d v = (T1 * p_link - T0 * p_link) / 1e-6;
      EXPECT_TRUE(J.col(i).head<3>().isApprox(w, 1e-4));
      EXPECT_LT((J.col(i).tail<3>() - v).norm(), 1e-6);
    }
    EXPECT_EQ(J.cols(), 6);
    EXPECT_TRUE(jacobian(hand, joints, 3, p_link).rightCols(2).isZero());
  }
}

TEST(Kinematics, PerturbedLinksAreDisplacedByTheStatedAmount) {
  RandomStream random(5, "links");
  const Description hand = planar_arm();
  double sum = 0;
  const int trials = 2000;
  for (int i = 0; i < trials; ++i) {
    const Description perturbed = with_perturbed_links(hand, 0.002, random);
    sum +=
        (perturbed.links[1].T_parent_link.translation() - hand.links[1].T_parent_link.translation())
            .squaredNorm();
  }
  EXPECT_NEAR(std::sqrt(sum / trials), 0.002, 0.0001);
}

TEST(MountPosition, PoseTurnsByYawThenPitchThenRoll) {
  MountPosition mount;
  mount.xyz = {1, 2, 3};
  mount.ypr = {M_PI / 2, 0, M_PI / 2};
  const Eigen::Vector3d p = mount.pose() * Eigen::Vector3d(0, 1, 0);
  EXPECT_TRUE(p.isApprox(Eigen::Vector3d(1, 2, 4), 1e-12));
}

TEST(MountPosition, BetweenTwoGoesFromOneToTheOther) {
  const MountPosition a{{1, 2, 3}, {0, 0.5, 0}}, b{{2, 2, 1}, {1, 0.5, -2}};
  const MountPosition quarter = between(a, b, 0.25);
  EXPECT_TRUE(quarter.xyz.isApprox(Eigen::Vector3d(1.25, 2, 2.5), 1e-12));
  EXPECT_TRUE(quarter.ypr.isApprox(Eigen::Vector3d(0.25, 0.5, -0.5), 1e-12));
}

TEST(WholeTicks, AreTheNearestAndAtLeastOne) {
  EXPECT_EQ(whole_ticks(0.354), 35);
  EXPECT_EQ(whole_ticks(0.356), 36);
  EXPECT_EQ(whole_ticks(0), 1);
}

TEST(TouchingFingers, AreThoseWithAnyContact) {
  HandReading reading;
  const TipContact light{{0, 0, 0}, {0, 0, 1}, {0, 0, 0}};
  reading.contacts = {{light, light}, {}, {light}};
  EXPECT_EQ(touching_fingers(reading), 2);
  EXPECT_EQ(touching_fingers(HandReading()), 0);
}

TEST(MountPosition, IsFoundAgainFromItsPoseAndOneNearIt) {
  RandomStream rng(3);
  for (int i = 0; i < 2000; ++i) {
    MountPosition mount, near;
    for (int k = 0; k < 3; ++k) {
      mount.ypr[k] = rng.uniform(-9, 9);
      near.ypr[k] = mount.ypr[k] + rng.uniform(-0.3, 0.3);
    }
    const MountPosition found = nearest_mount(mount.pose(), near);
    EXPECT_TRUE(found.pose().isApprox(mount.pose(), 1e-9));
    if (std::abs(std::cos(mount.ypr[1])) > 0.5) {
      EXPECT_LT((found.ypr - mount.ypr).norm(), 1e-9);
    }
    mount.ypr[1] = M_PI / 2;
    const MountPosition up = nearest_mount(mount.pose(), mount);
    EXPECT_LT((up.ypr - mount.ypr).norm(), 1e-6);
  }
}

TEST(MountPosition, IsFoundAgainFromItsPose) {
  RandomStream random(8);
  for (int trial = 0; trial < 50; ++trial) {
    MountPosition mount;
    mount.xyz = random.normal3();
    mount.ypr = {random.uniform(-3, 3), random.uniform(-1.5, 1.5), random.uniform(-3, 3)};
    const MountPosition found = MountPosition::at(mount.pose());
    EXPECT_LT((found.xyz - mount.xyz).norm(), 1e-12);
    EXPECT_LT((found.ypr - mount.ypr).norm(), 1e-9);
  }
}

TEST(WholeTicks, AreBounded) {
  EXPECT_EQ(whole_ticks(1e12), 1'000'000'000);
  EXPECT_EQ(whole_ticks(std::numeric_limits<double>::infinity()), 1'000'000'000);
  EXPECT_EQ(whole_ticks(-1e12), 1);
  EXPECT_EQ(whole_ticks(std::numeric_limits<double>::quiet_NaN()), 1);
}

TEST(TipForce, OfAContactWithoutANormalIsItsWholeForce) {
  HandReading reading;
  reading.contacts = {{{{0, 0, 0}, {0, 0, 0}, {0, 3, 4}}}, {{{0, 0, 0}, {0, 0, 1}, {0, 3, -4}}}};
  EXPECT_EQ(tip_force(reading, 0), 5);
  EXPECT_EQ(tip_force(reading, 1), 4);
  EXPECT_EQ(count_contacts(reading, 4.5), 1);
}

TEST(DistanceFromTip, IsThatFromTheCapsule) {
  const Finger finger{.name = "", .link = 2, .tip = {{0, 0, 0}, {0, 0, 0.02}, 0.008}};
  EXPECT_NEAR(distance_from_tip({0.108, 0, 0.01}, finger), 0.1, 1e-12);
  EXPECT_NEAR(distance_from_tip({0, 0, 5.028}, finger), 5, 1e-12);
  EXPECT_EQ(distance_from_tip({0.001, 0, 0.01}, finger), 0);
  EXPECT_EQ(distance_from_tip({1e200, 0, 0}, Finger{}), 0) << "where the tip is is not known";
}

}  // namespace
}  // namespace palpate::hand
