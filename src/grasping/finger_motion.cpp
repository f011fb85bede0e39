// SPDX-License-Identifier: Apache-2.0
#include "palpate/grasping/finger_motion.hpp"

#include <Eigen/Cholesky>
#include <optional>

namespace palpate::grasping {
namespace {

constexpr double kDamping = 0.005;     // m/rad, small against the length of a finger
constexpr double kNearlyDrawn = 0.05;  // rad before J2 draws J1 along

using Columns = Eigen::Matrix<double, 3, Eigen::Dynamic, 0, 3, hand::kMaxJoints>;

/// How a point of a finger's distal link moves with its actuators, mount's axes, m/rad.
Columns point_jacobian(const hand::Description& hand, const hand::JointVector& joints, int finger,
                       const Eigen::Vector3d& p_link) {
  const auto J =
      hand::jacobian(hand, joints, hand.fingers[static_cast<std::size_t>(finger)].link, p_link);
  Columns columns = Columns::Zero(3, hand.actuator_count());
  for (int i = 0; i < hand.actuator_count(); ++i) {
    const hand::Actuator& actuator = hand.actuators[static_cast<std::size_t>(i)];
    if (actuator.finger != finger) continue;
    if (!actuator.coupling) {
      for (const hand::DrivenJoint& driven : actuator.joints) {
        columns.col(i) += driven.share * J.block<3, 1>(3, driven.joint);
      }
      continue;
    }
    const int middle = actuator.joints[0].joint, distal = actuator.joints[1].joint;
    const bool drawn =
        joints[middle] - joints[distal] > actuator.coupling->follow_angle - kNearlyDrawn;
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

hand::ActuatorVector finger_motion(const hand::Description& hand, const hand::JointVector& joints,
                                   std::span<const tactile::Contact> contacts,
                                   const Eigen::Vector3d& center, const GraspMotion& motion) {
  const auto T_mount_link = hand::forward_kinematics(hand, joints);
  hand::ActuatorVector result = hand::ActuatorVector::Zero(hand.actuator_count());
  for (int finger = 0; finger < hand.finger_count(); ++finger) {
    const auto contact = contact_of(contacts, finger);
    if (!contact) continue;
    const auto k = static_cast<std::size_t>(finger);
    const Eigen::Vector3d way = motion.twist.tail<3>() +
                                motion.twist.head<3>().cross(contact->p - center) -
                                motion.press[k] * contact->n;
    const auto link = static_cast<std::size_t>(hand.fingers[k].link);
    const Columns J =
        point_jacobian(hand, joints, finger, T_mount_link[link].inverse() * contact->p);
    const Eigen::Matrix3d JJ =
        J.lazyProduct(J.transpose()) + kDamping * kDamping * Eigen::Matrix3d::Identity();
    result += J.transpose() * JJ.llt().solve(way);
  }
  return result;
}

}  // namespace palpate::grasping
