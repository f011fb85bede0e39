// SPDX-License-Identifier: Apache-2.0
#include "palpate/grasping/grasp_matrix.hpp"

#include <gtest/gtest.h>

#include "grasping/grasps.hpp"
#include "hand/descriptions.hpp"
#include "palpate/core/error.hpp"
#include "palpate/hand/shadow.hpp"

namespace palpate::grasping {
namespace {

/// Three links in a row, each turned by one joint, at 5 cm from one another.
hand::Description chain() {
  hand::Description hand = hand::shadow_hand();
  for (int i = 0; i < 3; ++i) {
    hand::Link link;
    link.parent = i - 1;
    link.T_parent_link.translation() << 0.05, 0, 0.01;
    link.axis = i == 1 ? Eigen::Vector3d::UnitZ() : Eigen::Vector3d::UnitY();
    link.joint = i;
    hand.links.push_back(link);
  }
  return hand;
}

Eigen::VectorXd random_vector(Eigen::Index size, RandomStream& random) {
  Eigen::VectorXd v(size);
  for (Eigen::Index i = 0; i < size; ++i) v[i] = random.normal();
  return v;
}

TEST(Grasp, ContactFrameLooksIntoTheObject) {
  RandomStream random(1);
  for (int trial = 0; trial < 50; ++trial) {
    const Eigen::Vector3d p = random.normal3(), n = random.unit_vector();
    const Eigen::Isometry3d T = contact_frame(p, n);
    EXPECT_LT((T.linear().col(0) + n).norm(), 1e-12);
    EXPECT_LT((T.linear().transpose() * T.linear() - Eigen::Matrix3d::Identity()).norm(), 1e-12);
    EXPECT_NEAR(T.linear().determinant(), 1, 1e-12);
    EXPECT_EQ(T.translation(), p);
  }
  EXPECT_THROW(contact_frame(Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero()), BadInput);
  EXPECT_THROW(contact_frame(Eigen::Vector3d::Constant(std::nan("")), Eigen::Vector3d::UnitX()),
               BadInput);
}

TEST(Grasp, ObjectWrenchIsThatOfTheForcesAtTheirPlaces) {
  RandomStream random(2);
  const GraspContacts contacts = on_ball(4, 0.04, ContactModel::soft_finger, random);
  const Eigen::Vector3d center = 0.1 * random.normal3();
  const Eigen::VectorXd w = random_vector(24, random);
  Vector6d expected = Vector6d::Zero();
  for (int i = 0; i < 4; ++i) {
    const auto& T = contacts[static_cast<std::size_t>(i)].T_mount_contact;
    const Eigen::Vector3d m = T.linear() * w.segment<3>(6 * i);
    const Eigen::Vector3d f = T.linear() * w.segment<3>(6 * i + 3);
    expected.head<3>() += m + (T.translation() - center).cross(f);
    expected.tail<3>() += f;
  }
  EXPECT_LT((object_wrench(grasp_matrix(contacts, center), w) - expected).norm(), 1e-12);
}

TEST(Grasp, ContactTwistsAreVelocitiesOfTheObjectsPoints) {
  RandomStream random(3);
  const GraspContacts contacts = on_ball(3, 0.04, ContactModel::soft_finger, random);
  const Eigen::Vector3d center = 0.1 * random.normal3();
  const Vector6d twist = random_vector(6, random);
  const Eigen::VectorXd nu = object_contact_twists(grasp_matrix(contacts, center), twist);
  for (int i = 0; i < 3; ++i) {
    const auto& T = contacts[static_cast<std::size_t>(i)].T_mount_contact;
    const Eigen::Vector3d v = twist.tail<3>() + twist.head<3>().cross(T.translation() - center);
    EXPECT_LT((T.linear() * nu.segment<3>(6 * i) - twist.head<3>()).norm(), 1e-12);
    EXPECT_LT((T.linear() * nu.segment<3>(6 * i + 3) - v).norm(), 1e-12);
  }
}

TEST(Grasp, HandJacobianIsTheDerivativeOfTheContacts) {
  const hand::Description hand = chain();
  RandomStream random(4);
  hand::JointVector joints = hand::JointVector::Zero(hand::kShadowJoints),
                    rates = hand::JointVector::Zero(hand::kShadowJoints);
  for (int i = 0; i < 3; ++i) {
    joints[i] = random.uniform(-1, 1);
    rates[i] = random.normal();
  }
  GraspContacts contacts = on_ball(2, 0.1, ContactModel::hard_finger, random);
  contacts[0].link = 2;
  contacts[1].link = 1;
  const Eigen::VectorXd nu = hand_contact_twists(hand_jacobian(hand, joints, contacts), rates);
  constexpr double kStep = 1e-6;
  const auto before = hand::forward_kinematics(hand, joints - kStep * rates);
  const auto now = hand::forward_kinematics(hand, joints);
  const auto after = hand::forward_kinematics(hand, joints + kStep * rates);
  for (std::size_t i = 0; i < 2; ++i) {
    const auto link = static_cast<std::size_t>(contacts[i].link);
    const Eigen::Isometry3d& T = contacts[i].T_mount_contact;
    const Eigen::Vector3d p_link = now[link].inverse() * T.translation();
    const Eigen::Vector3d v = (after[link] * p_link - before[link] * p_link) / (2 * kStep);
    const Eigen::Vector3d w =
        log_so3(after[link].linear() * before[link].linear().transpose()) / (2 * kStep);
    const auto row = static_cast<Eigen::Index>(6 * i);
    EXPECT_LT((T.linear() * nu.segment<3>(row) - w).norm(), 1e-7);
    EXPECT_LT((T.linear() * nu.segment<3>(row + 3) - v).norm(), 1e-7);
  }
}

TEST(Grasp, PowerIsTheSameOnAllSides) {
  const hand::Description hand = chain();
  RandomStream random(5);
  GraspContacts contacts = on_ball(3, 0.1, ContactModel::soft_finger, random);
  for (GraspContact& contact : contacts) contact.link = 2;
  const Eigen::MatrixXd G = grasp_matrix(contacts, random.normal3());
  const Eigen::MatrixXd J =
      hand_jacobian(hand, hand::JointVector::Zero(hand::kShadowJoints), contacts);
  const Eigen::VectorXd w = random_vector(18, random);
  const Vector6d twist = random_vector(6, random);
  const hand::JointVector rates = random_vector(hand::kShadowJoints, random);
  EXPECT_NEAR(w.dot(object_contact_twists(G, twist)), object_wrench(G, w).dot(twist), 1e-10);
  EXPECT_NEAR(w.dot(hand_contact_twists(J, rates)), joint_torques(J, w).dot(rates), 1e-10);
}

TEST(Grasp, TransmissionStacksTheContactsModels) {
  RandomStream random(6);
  GraspContacts contacts = on_ball(3, 0.1, ContactModel::soft_finger, random);
  contacts[1].model = ContactModel::frictionless;
  contacts[2].model = ContactModel::hard_finger;
  const Eigen::MatrixXd H = transmission(contacts);
  EXPECT_EQ(H.rows(), 4 + 1 + 3);
  EXPECT_EQ(H.cols(), 18);
  EXPECT_LT((H * H.transpose() - Eigen::MatrixXd::Identity(8, 8)).norm(), 1e-15);
  EXPECT_EQ(H(4, 6 + 3), 1);
}

TEST(Grasp, ReadingsBecomeContacts) {
  hand::Description hand = chain();
  for (hand::Finger& finger : hand.fingers) finger.link = 2;
  hand.fingers[4].link = 1;
  hand::HandReading reading = hand::resting_reading();
  reading.joints.head<3>() << 0.3, -0.4, 0.5;
  reading.contacts[4].push_back({{0.01, 0, 0}, {0, 0, 1}, {0, 0, -2}});
  const GraspContacts contacts =
      grasp_contacts(hand, reading, ContactModel::hard_finger, {.sliding = 0.7});
  ASSERT_EQ(contacts.size(), 1u);
  const Eigen::Isometry3d T = hand::forward_kinematics(hand, reading.joints)[1];
  EXPECT_EQ(contacts[0].link, 1);
  EXPECT_LT((contacts[0].T_mount_contact.translation() - T * Eigen::Vector3d(0.01, 0, 0)).norm(),
            1e-12);
  EXPECT_LT((contacts[0].T_mount_contact.linear().col(0) + T.linear().col(2)).norm(), 1e-12);
}

TEST(Grasp, RejectsSizesThatDoNotFit) {
  RandomStream random(7);
  const GraspContacts contacts = on_ball(2, 0.1, ContactModel::hard_finger, random);
  const Eigen::MatrixXd G = grasp_matrix(contacts, Eigen::Vector3d::Zero());
  EXPECT_THROW(object_wrench(G, Eigen::VectorXd::Zero(11)), BadInput);
  EXPECT_THROW(object_contact_twists(G.transpose(), Vector6d::Zero()), BadInput);
  EXPECT_THROW(hand_jacobian(chain(), hand::JointVector::Zero(hand::kShadowJoints), contacts),
               BadInput);
  EXPECT_THROW(
      joint_torques(Eigen::MatrixXd::Zero(12, hand::kShadowJoints), Eigen::VectorXd::Zero(6)),
      BadInput);
}

}  // namespace
}  // namespace palpate::grasping
