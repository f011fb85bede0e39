// SPDX-License-Identifier: Apache-2.0
#include "palpate/grasping/force_distribution.hpp"

#include <gtest/gtest.h>

#include <limits>
#include <numbers>

#include "grasping/coupled_finger.hpp"
#include "palpate/core/error.hpp"
#include "palpate/core/random.hpp"
#include "palpate/hand/shadow.hpp"

namespace palpate::grasping {
namespace {

constexpr double kFriction = 0.5;

double pressing(const ForceDistribution& balanced, const std::vector<tactile::Contact>& contacts) {
  double sum = 0;
  for (std::size_t i = 0; i < contacts.size(); ++i) {
    sum -= balanced.forces[i].dot(contacts[i].n);
  }
  return sum;
}

TEST(DistributeForces, OppositeContactsShareThePressEqually) {
  const std::vector contacts = {contact({0.02, 0, 0}, {1, 0, 0}),
                                contact({-0.02, 0, 0}, {-1, 0, 0})};
  const auto balanced = distribute_forces(contacts, kFriction, 6);
  EXPECT_LT(balanced.wrench_residual, 1e-3);
  EXPECT_NEAR(-balanced.forces[0].dot(contacts[0].n), 3, 0.01);
  EXPECT_LT((balanced.forces[0] + balanced.forces[1]).norm(), 0.01);
}

TEST(DistributeForces, ThumbBearsWhatFourFingersPress) {
  std::vector contacts = {contact({0, -0.02, 0}, {0, -1, 0})};
  for (const double x : {-0.03, -0.01, 0.01, 0.03}) {
    contacts.push_back(contact({x, 0.02, 0}, {0, 1, 0}));
  }
  const auto balanced = distribute_forces(contacts, kFriction, 10);
  EXPECT_LT(balanced.wrench_residual, 0.02);
  EXPECT_NEAR(-balanced.forces[0].dot(contacts[0].n), 5, 0.1);
}

TEST(DistributeForces, ForcesLieInTheirConesAndPressWithTheTotal) {
  RandomStream random(5);
  for (int trial = 0; trial < 50; ++trial) {
    std::vector<tactile::Contact> contacts;
    const int count = 2 + trial % 5;
    for (int i = 0; i < count; ++i) {
      const Eigen::Vector3d n = random.unit_vector();
      contacts.push_back(contact(0.03 * n + 0.01 * random.unit_vector(), n));
    }
    const auto balanced = distribute_forces(contacts, kFriction, 7);
    EXPECT_NEAR(pressing(balanced, contacts), 7, 1e-6);
    for (int i = 0; i < count; ++i) {
      const auto k = static_cast<std::size_t>(i);
      const double normal = -balanced.forces[k].dot(contacts[k].n);
      const double side = (balanced.forces[k] + normal * contacts[k].n).norm();
      EXPECT_GE(normal, -1e-9);
      EXPECT_LE(side, kFriction * normal + 1e-9);
    }
  }
}

TEST(DistributeForces, ContactsOnOneSideCannotBeBalanced) {
  const std::vector contacts = {contact({0, 0, 0.02}, {0, 0, 1}),
                                contact({0.02, 0, 0.02}, {0, 0, 1})};
  EXPECT_NEAR(distribute_forces(contacts, kFriction, 5).wrench_residual, 1, 0.05);
}

TEST(DistributeForces, BearsTheWeightByFriction) {
  const std::vector contacts = {contact({0.02, 0, 0}, {1, 0, 0}),
                                contact({-0.02, 0, 0}, {-1, 0, 0})};
  const auto light = distribute_forces(contacts, kFriction, 6, Load{{0, 0, 0}, {0, 0, -1}});
  const auto heavy = distribute_forces(contacts, kFriction, 6, Load{{0, 0, 0}, {0, 0, -12}});
  EXPECT_LT(light.wrench_residual, 0.02);
  EXPECT_GT(heavy.wrench_residual, 1);  // 6 N at 0.5 hold 3 N
}

TEST(DistributeForces, NoContactGivesNoForce) {
  const auto balanced = distribute_forces({}, kFriction, 5);
  EXPECT_TRUE(balanced.forces.empty());
  EXPECT_EQ(balanced.wrench_residual, std::numeric_limits<double>::infinity());
}

TEST(PressingTorques, AreForceTimesLeverAndTheirMeanForACoupledPair) {
  const auto hand = coupled_finger();
  const std::vector contacts = {contact({0.05, 0, 0}, {0, -1, 0})};
  const std::vector<Eigen::Vector3d> forces = {{0, 2, 0}};
  const auto torques =
      pressing_torques(hand, hand::JointVector::Zero(hand::kShadowJoints), contacts, forces);
  EXPECT_NEAR(torques[hand::shadow_hand().actuator("FFJ0")], 0.5 * 2 * (0.05 + 0.02), 1e-12);
  EXPECT_EQ(torques[hand::shadow_hand().actuator("MFJ0")], 0);
  EXPECT_THROW(pressing_torques(hand, hand::JointVector::Zero(hand::kShadowJoints), contacts, {}),
               BadInput);
}

}  // namespace
}  // namespace palpate::grasping
