// SPDX-License-Identifier: Apache-2.0
#include "palpate/grasping/finger_motion.hpp"

#include <gtest/gtest.h>

#include "palpate/core/assets.hpp"
#include "palpate/core/random.hpp"
#include "palpate/hand/kinematics.hpp"
#include "palpate/hand/shadow.hpp"
#include "palpate/simulation/hand/load_hand.hpp"
#include "palpate/simulation/world/world.hpp"

namespace palpate::grasping {
namespace {

/// A half-closed hand whose fingertips touch something at their ends.
struct HalfClosed {
  HalfClosed() {
    for (const std::string finger : {"FF", "MF", "RF", "LF"}) {
      posture[hand::shadow_hand().actuator(finger + "J3")] = 0.5;
      posture[hand::shadow_hand().actuator(finger + "J0")] = 1.2;
    }
    posture[hand::shadow_hand().actuator("THJ4")] = 1.0;
    posture[hand::shadow_hand().actuator("THJ2")] = 0.2;
    posture[hand::shadow_hand().actuator("THJ1")] = 0.4;
    const auto T = hand::forward_kinematics(model, joints());
    for (std::size_t finger = 0; finger < hand::kShadowFingers; ++finger) {
      const auto& T_mount_tip = T[static_cast<std::size_t>(model.fingers[finger].link)];
      tactile::Contact contact;
      contact.finger = static_cast<int>(finger);
      contact.p = T_mount_tip * (model.fingers[finger].tip.b + Eigen::Vector3d(0, -0.006, 0));
      contact.n = Eigen::Vector3d::UnitY();
      contacts.push_back(contact);
    }
  }
  hand::JointVector joints() const { return hand::joints_in_free_flexion(model, posture); }

  hand::Description model = simulation::load_shadow_hand(asset("shadow_hand/right_hand.xml"));
  hand::ActuatorVector posture = hand::ActuatorVector::Zero(hand::kShadowActuators);
  std::vector<tactile::Contact> contacts;
};

/// Where the touching points of the fingertips are after a motion of the actuators.
std::vector<Eigen::Vector3d> carried(const HalfClosed& hand, const hand::ActuatorVector& motion) {
  const auto before = hand::forward_kinematics(hand.model, hand.joints());
  const auto after = hand::forward_kinematics(
      hand.model, hand::joints_in_free_flexion(hand.model, hand.posture + motion));
  std::vector<Eigen::Vector3d> points;
  for (const auto& contact : hand.contacts) {
    const auto link =
        static_cast<std::size_t>(hand.model.fingers[static_cast<std::size_t>(contact.finger)].link);
    points.push_back(after[link] * before[link].inverse() * contact.p);
  }
  return points;
}

TEST(FingerMotion, FingertipsFollowASmallTwistOfTheObject) {
  const HalfClosed hand;
  RandomStream random(7, "twists");
  const Eigen::Vector3d center(0.02, 0, -0.06);
  for (int i = 0; i < 20; ++i) {
    GraspMotion motion;
    motion.twist << 0.01 * random.unit_vector(), 0.0005 * random.unit_vector();
    const auto points =
        carried(hand, finger_motion(hand.model, hand.joints(), hand.contacts, center, motion));
    for (std::size_t k = 0; k < hand.contacts.size(); ++k) {
      const Eigen::Vector3d wanted =
          motion.twist.tail<3>() + motion.twist.head<3>().cross(hand.contacts[k].p - center);
      const Eigen::Vector3d got = points[k] - hand.contacts[k].p;
      // Three joints a finger reach every direction; damping keeps a part of it.
      EXPECT_LT((got - wanted).norm(), 0.15 * wanted.norm() + 2e-5) << "finger " << k;
    }
  }
}

TEST(FingerMotion, PressGoesAgainstTheNormalOfItsFingerAlone) {
  const HalfClosed hand;
  GraspMotion motion;
  motion.press[2] = 0.0005;
  const auto points =
      carried(hand, finger_motion(hand.model, hand.joints(), hand.contacts, {0, 0, 0}, motion));
  for (std::size_t k = 0; k < hand.contacts.size(); ++k) {
    const Eigen::Vector3d way = points[k] - hand.contacts[k].p;
    const Eigen::Vector3d wanted =
        k == 2 ? Eigen::Vector3d(0, -0.0005, 0) : Eigen::Vector3d::Zero();
    EXPECT_LT((way - wanted).norm(), 1e-4) << "finger " << k;
  }
}

TEST(FingerMotion, FingersWithoutContactStay) {
  HalfClosed hand;
  hand.contacts.resize(2);
  GraspMotion motion;
  motion.twist << 0.01, 0, 0, 0, 0.001, 0;
  const auto moved = finger_motion(hand.model, hand.joints(), hand.contacts, {0, 0, 0}, motion);
  for (int i = 0; i < hand::kShadowActuators; ++i) {
    const int finger = hand.model.actuators[static_cast<std::size_t>(i)].finger;
    if (finger < 0 || finger > 1) {
      EXPECT_EQ(moved[i], 0) << hand::kShadowActuatorNames[static_cast<std::size_t>(i)];
    }
  }
  EXPECT_GT(moved.norm(), 0);
}

}  // namespace
}  // namespace palpate::grasping
