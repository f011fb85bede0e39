// SPDX-License-Identifier: Apache-2.0
#include "palpate/grasping/force_closure.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <string>

#include "grasping/grasps.hpp"
#include "palpate/core/error.hpp"

namespace palpate::grasping {
namespace {

constexpr Friction kFriction = {.sliding = 0.5, .eccentricity = 0.01};

TEST(ForceClosure, TwoOpposedSoftFingersClose) {
  const auto result = force_closure(around_disc(2, 0.03, ContactModel::soft_finger, kFriction));
  EXPECT_TRUE(result.closed);
  EXPECT_EQ(result.rank, 6);
  EXPECT_NEAR(result.margin, 0.5 * 0.5, 1e-6);  // half a newton each, mu 0.5, straight through
}

TEST(ForceClosure, TwoHardFingersLeaveTheTwistAboutTheirLine) {
  const auto result = force_closure(around_disc(2, 0.03, ContactModel::hard_finger, kFriction));
  EXPECT_FALSE(result.closed);
  EXPECT_EQ(result.rank, 5);
  EXPECT_GT(result.margin, 0);
}

TEST(ForceClosure, ThreeHardFingersAroundADiscClose) {
  const auto result = force_closure(around_disc(3, 0.03, ContactModel::hard_finger, kFriction));
  EXPECT_TRUE(result.closed);
  EXPECT_NEAR(result.margin, 0.5 / 3, 1e-6);
}

TEST(ForceClosure, ABallWithoutFrictionIsNeverHeld) {
  RandomStream random(1);
  const auto result = force_closure(on_ball(12, 0.03, ContactModel::frictionless, random));
  EXPECT_FALSE(result.closed);
  EXPECT_EQ(result.rank, 3);
}

TEST(ForceClosure, OpposedFingersCloseIfTheirLineIsInBothCones) {
  // Fingers on a wedge: each normal is off the line between them by the given angle.
  for (const double mu : {0.2, 0.5, 1.0}) {
    for (const double share : {0.95, 1.05}) {
      const double angle = share * std::atan(mu);
      const Eigen::Vector3d left(-std::cos(angle), std::sin(angle), 0);
      const Eigen::Vector3d right(std::cos(angle), std::sin(angle), 0);
      const Friction friction = {.sliding = mu, .eccentricity = 0.01};
      const auto model = ContactModel::soft_finger;
      const GraspContacts contacts = {contact_at({-0.03, 0, 0}, left, model, friction),
                                      contact_at({0.03, 0, 0}, right, model, friction)};
      EXPECT_EQ(force_closure(contacts).closed, share < 1) << "mu " << mu;
    }
  }
}

TEST(ForceClosure, NoContactsAndOneSidedContactsDoNotClose) {
  EXPECT_FALSE(force_closure({}).closed);
  GraspContacts above;
  for (const double x : {-0.02, 0.0, 0.03}) {
    above.push_back(contact_at({x, x * x, 0}, {0, 0, 1}, ContactModel::soft_finger, kFriction));
  }
  const auto result = force_closure(above);
  EXPECT_FALSE(result.closed);
  EXPECT_LT(result.margin, 0);
}

TEST(ForceClosure, DoesNotDependOnTheFrame) {
  RandomStream random(2);
  int closed = 0;
  for (int trial = 0; trial < 12; ++trial) {
    const GraspContacts contacts = on_ball(3, 0.03, ContactModel::soft_finger, random);
    Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
    T.linear() = exp_so3(random.normal3());
    T.translation() = random.normal3();
    GraspContacts moved = contacts;
    for (GraspContact& contact : moved) contact.T_mount_contact = T * contact.T_mount_contact;
    const auto a = force_closure(contacts), b = force_closure(moved);
    EXPECT_EQ(a.closed, b.closed);
    EXPECT_NEAR(a.margin, b.margin, 1e-6);
    EXPECT_NEAR(grasp_quality(contacts, Eigen::Vector3d::Zero()),
                grasp_quality(moved, T.translation()), 1e-3);
    closed += a.closed;
  }
  EXPECT_GT(closed, 0);
  EXPECT_LT(closed, 12);
}

TEST(ForceClosure, MoreFrictionAndMoreContactsNeverHurt) {
  RandomStream random(3);
  for (int trial = 0; trial < 30; ++trial) {
    GraspContacts contacts = on_ball(3, 0.03, ContactModel::hard_finger, random);
    const double quality = grasp_quality(contacts, Eigen::Vector3d::Zero());
    GraspContacts rough = contacts;
    for (GraspContact& contact : rough) contact.friction.sliding *= 1.5;
    EXPECT_GE(grasp_quality(rough, Eigen::Vector3d::Zero()), quality - 1e-9);
    EXPECT_TRUE(!force_closure(contacts).closed || force_closure(rough).closed);
    contacts.push_back(contact_at({0, 0, 0.03}, {0, 0, 1}, ContactModel::hard_finger));
    EXPECT_GE(grasp_quality(contacts, Eigen::Vector3d::Zero()), quality - 1e-9);
  }
}

/// Two pushes on each face of a cube, whose wrenches are the corners of a square in each of three
/// planes that are at right angles: force i with moment i + 2.
GraspContacts on_cube(double half, double offset) {
  GraspContacts contacts;
  for (int axis = 0; axis < 3; ++axis) {
    for (const double side : {-1.0, 1.0}) {
      for (const double way : {-1.0, 1.0}) {
        const Eigen::Vector3d out = side * Eigen::Vector3d::Unit(axis);
        const Eigen::Vector3d p = half * out + way * offset * Eigen::Vector3d::Unit((axis + 1) % 3);
        contacts.push_back(contact_at(p, out, ContactModel::frictionless));
      }
    }
  }
  return contacts;
}

TEST(GraspQuality, OfACubePushedOnAllSides) {
  // Support function max_i (|f_i| + |m_i|): least over unit wrenches where all pairs are alike.
  const double quality =
      grasp_quality(on_cube(0.03, 0.05), Eigen::Vector3d::Zero(), {.edges = 8, .length = 0.05});
  EXPECT_NEAR(quality, 1 / std::sqrt(3.0), 1e-9);
  EXPECT_TRUE(force_closure(on_cube(0.03, 0.05)).closed);
}

TEST(GraspQuality, IsNoneWithoutForceClosureAndGrowsWithTheEdges) {
  EXPECT_EQ(grasp_quality({}, Eigen::Vector3d::Zero()), 0);
  EXPECT_EQ(grasp_quality(around_disc(2, 0.03, ContactModel::hard_finger), Eigen::Vector3d::Zero()),
            0);
  const GraspContacts disc = around_disc(3, 0.03, ContactModel::hard_finger, kFriction);
  const double coarse = grasp_quality(disc, Eigen::Vector3d::Zero(), {.edges = 4, .length = 0.03});
  const double fine = grasp_quality(disc, Eigen::Vector3d::Zero(), {.edges = 16, .length = 0.03});
  EXPECT_GT(coarse, 0);
  EXPECT_GE(fine, coarse);
  EXPECT_LT(fine, 0.5);
}

TEST(GraspQuality, IsPositiveOnlyWithForceClosure) {
  RandomStream random(4);
  int positive = 0;
  for (int trial = 0; trial < 40; ++trial) {
    const GraspContacts contacts = on_ball(4, 0.03, ContactModel::hard_finger, random);
    const double quality = grasp_quality(contacts, Eigen::Vector3d::Zero());
    EXPECT_TRUE(quality <= 1e-6 || force_closure(contacts).closed);
    positive += quality > 1e-6;
  }
  EXPECT_GT(positive, 2);
}

TEST(GraspQuality, RejectsOptionsOutOfRange) {
  const GraspContacts disc = around_disc(3, 0.03, ContactModel::hard_finger);
  EXPECT_THROW(grasp_quality(disc, Eigen::Vector3d::Zero(), {.edges = 2}), BadInput);
  EXPECT_THROW(grasp_quality(disc, Eigen::Vector3d::Zero(), {.edges = 8, .length = 0}), BadInput);
}

TEST(ForceClosure, AContactThatIsNotFiniteIsNamedNotJudged) {
  GraspContacts disc = around_disc(3, 0.03, ContactModel::hard_finger);
  const Eigen::Vector3d nowhere = Eigen::Vector3d::Constant(std::nan(""));
  EXPECT_THROW(grasp_quality(disc, nowhere), BadInput);
  disc[1].T_mount_contact.translation().y() = std::nan("");
  try {
    force_closure(disc);
    FAIL() << "judged";
  } catch (const BadInput& error) {
    EXPECT_NE(std::string(error.what()).find("contact 1"), std::string::npos) << error.what();
  }
  EXPECT_THROW(grasp_quality(disc, Eigen::Vector3d::Zero()), BadInput);
}

Vector6d lift(double newtons) {
  Vector6d wrench = Vector6d::Zero();
  wrench[5] = newtons;
  return wrench;
}

TEST(Balance, TwoSoftFingersCarryAWeightWithTheLeastSqueeze) {
  const GraspContacts contacts = around_disc(2, 0.03, ContactModel::soft_finger, kFriction);
  const Balance balance = balance_wrench(contacts, Eigen::Vector3d::Zero(), lift(3));
  ASSERT_EQ(balance.status, BalanceStatus::balanced);
  for (int i = 0; i < 2; ++i) {
    EXPECT_NEAR(balance.contact_wrenches[6 * i + 3], 3, 1e-3);  // 3 N / 2 / mu
    EXPECT_NEAR(balance.contact_wrenches.segment<2>(6 * i + 4).norm(), 1.5, 1e-3);
  }
}

TEST(Balance, SaysWhenTheForcesWouldBeTooGreat) {
  const GraspContacts contacts = around_disc(2, 0.03, ContactModel::soft_finger, kFriction);
  EXPECT_EQ(
      balance_wrench(contacts, Eigen::Vector3d::Zero(), lift(3), {.max_normal_force = 3.1}).status,
      BalanceStatus::balanced);
  const Balance weak =
      balance_wrench(contacts, Eigen::Vector3d::Zero(), lift(3), {.max_normal_force = 2.9});
  EXPECT_EQ(weak.status, BalanceStatus::impossible);
  EXPECT_LT(weak.slack, 0);
  EXPECT_EQ(weak.contact_wrenches.size(), 0);
}

TEST(Balance, AFloorCarriesButDoesNotPull) {
  GraspContacts floor;
  for (int i = 0; i < 3; ++i) {
    const double angle = 2 * std::numbers::pi * i / 3;
    floor.push_back(contact_at({0.03 * std::cos(angle), 0.03 * std::sin(angle), 0}, {0, 0, -1},
                               ContactModel::frictionless));
  }
  const Balance up = balance_wrench(floor, Eigen::Vector3d::Zero(), lift(6));
  ASSERT_EQ(up.status, BalanceStatus::balanced);
  for (int i = 0; i < 3; ++i) EXPECT_NEAR(up.contact_wrenches[6 * i + 3], 2, 1e-6);
  EXPECT_EQ(balance_wrench(floor, Eigen::Vector3d::Zero(), lift(-6)).status,
            BalanceStatus::impossible);
  Vector6d aside = lift(6);
  aside[3] = 1;
  EXPECT_EQ(balance_wrench(floor, Eigen::Vector3d::Zero(), aside).status,
            BalanceStatus::impossible);
}

TEST(Balance, ForcesMakeTheWrenchWithinTheirCones) {
  RandomStream random(5);
  int balanced = 0, closed = 0;
  for (int trial = 0; trial < 60; ++trial) {
    const GraspContacts contacts = on_ball(4, 0.03, ContactModel::soft_finger, random);
    Vector6d wrench;
    wrench << 0.02 * random.normal3(), random.normal3();
    const Balance balance =
        balance_wrench(contacts, Eigen::Vector3d::Zero(), wrench, {.max_normal_force = 1e4});
    const bool holds_all = force_closure(contacts).margin > 1e-2;
    closed += holds_all;
    EXPECT_TRUE(!holds_all || balance.status == BalanceStatus::balanced);
    if (balance.status != BalanceStatus::balanced) continue;
    ++balanced;
    const Eigen::MatrixXd G = grasp_matrix(contacts, Eigen::Vector3d::Zero());
    EXPECT_LT((object_wrench(G, balance.contact_wrenches) - wrench).norm(), 1e-6 * wrench.norm());
    for (int i = 0; i < 4; ++i) {
      const GraspContact& contact = contacts[static_cast<std::size_t>(i)];
      const Eigen::VectorXd force =
          transmission(contact.model) * balance.contact_wrenches.segment<6>(6 * i);
      EXPECT_TRUE(is_within_cone(contact.model, contact.friction, force));
    }
  }
  EXPECT_GT(closed, 10);
  EXPECT_GE(balanced, closed);
}

TEST(Balance, RejectsBadInput) {
  const GraspContacts disc = around_disc(3, 0.03, ContactModel::hard_finger);
  EXPECT_THROW(balance_wrench(disc, Eigen::Vector3d::Zero(), lift(std::nan(""))), BadInput);
  EXPECT_THROW(balance_wrench(disc, Eigen::Vector3d::Constant(std::nan("")), lift(1)), BadInput);
  EXPECT_THROW(balance_wrench(disc, Eigen::Vector3d::Zero(), lift(1), {.max_normal_force = -1}),
               BadInput);
}

}  // namespace
}  // namespace palpate::grasping
