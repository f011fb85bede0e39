// SPDX-License-Identifier: Apache-2.0
#include "palpate/grasping/finger_motion.hpp"

#include <Eigen/Cholesky>
#include <optional>
#include <string>

#include "palpate/hand/coupling.hpp"

namespace palpate::grasping {
namespace {

constexpr double kDamping = 0.005;     // m/rad, small against the length of a finger
constexpr double kNearlyDrawn = 0.05;  // rad before J2 draws J1 along

using Columns = Eigen::Matrix<double, 3, hand::kActuators>;

/// How a point of a finger's distal link moves with its actuators, base's axes, m/rad.
Columns point_jacobian(const hand::HandModel& hand, const hand::JointVector& joints, int finger,
                       const Eigen::Vector3d& p_link) {
  const auto J =
      hand::jacobian(hand, joints, hand.distal[static_cast<std::size_t>(finger)], p_link);
  Columns columns = Columns::Zero();
  for (int i = 0; i < hand::kActuators; ++i) {
    if (hand::finger_of_actuator(i) != finger) continue;
    std::string name(hand::kActuatorNames[static_cast<std::size_t>(i)]);
    if (name.back() != '0') {
      columns.col(i) = J.block<3, 1>(3, hand::joint_index(name));
      continue;
    }
    name.back() = '1';
    const int distal = hand::joint_index(name);
    name.back() = '2';
    const int middle = hand::joint_index(name);
    const bool drawn =
        joints[middle] - joints[distal] > hand::kShadowCoupling.follow_angle - kNearlyDrawn;
    const double share = drawn ? 0.5 : 1.0;  // of J0 that J2 takes
    columns.col(i) = share * J.block<3, 1>(3, middle) + (1 - share) * J.block<3, 1>(3, distal);
  }
  return columns;
}

/// Mean point and normal of a finger's contacts; nothing of a finger that does not touch.
std::optional<tactile::Contact> contact_of(std::span<const tactile::Contact> contacts, int finger) {
  tactile::Contact mean;
  mean.p.setZero();
  mean.n.setZero();
  int count = 0;
  for (const auto& contact : contacts) {
    if (contact.finger != finger) continue;
    mean.p += contact.p;
    mean.n += contact.n;
    ++count;
  }
  if (count == 0) return std::nullopt;
  mean.p /= count;
  mean.n.normalize();
  return mean;
}

}  // namespace

hand::ActuatorVector finger_motion(const hand::HandModel& hand, const hand::JointVector& joints,
                                   std::span<const tactile::Contact> contacts,
                                   const Eigen::Vector3d& center, const GraspMotion& motion) {
  const auto T_base_link = hand::forward_kinematics(hand, joints);
  hand::ActuatorVector result = hand::ActuatorVector::Zero();
  for (int finger = 0; finger < hand::kFingers; ++finger) {
    const auto contact = contact_of(contacts, finger);
    if (!contact) continue;
    const auto k = static_cast<std::size_t>(finger);
    const Eigen::Vector3d way = motion.twist.tail<3>() +
                                motion.twist.head<3>().cross(contact->p - center) -
                                motion.press[k] * contact->n;
    const auto link = static_cast<std::size_t>(hand.distal[k]);
    const Columns J =
        point_jacobian(hand, joints, finger, T_base_link[link].inverse() * contact->p);
    const Eigen::Matrix3d JJ =
        J * J.transpose() + kDamping * kDamping * Eigen::Matrix3d::Identity();
    result += J.transpose() * JJ.llt().solve(way);
  }
  return result;
}

}  // namespace palpate::grasping
