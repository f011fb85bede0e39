// SPDX-License-Identifier: Apache-2.0
#include "palpate/hand/kinematics.hpp"

#include <algorithm>
#include <cmath>

#include "palpate/core/se3.hpp"
#include "palpate/hand/hand.hpp"

namespace palpate::hand {

int whole_ticks(double seconds) {
  constexpr double kMost = 1e9;
  const double ticks = std::round(seconds / kTick);
  return ticks >= 1 ? static_cast<int>(std::min(ticks, kMost)) : 1;
}

Eigen::Isometry3d MountPosition::pose() const {
  Eigen::Isometry3d T_world_mount = Eigen::Isometry3d::Identity();
  T_world_mount.translation() = xyz;
  T_world_mount.linear() = (Eigen::AngleAxisd(ypr[0], Eigen::Vector3d::UnitZ()) *
                            Eigen::AngleAxisd(ypr[1], Eigen::Vector3d::UnitY()) *
                            Eigen::AngleAxisd(ypr[2], Eigen::Vector3d::UnitX()))
                               .toRotationMatrix();
  return T_world_mount;
}

MountPosition MountPosition::at(const Eigen::Isometry3d& T_world_mount) {
  const Eigen::Matrix3d& R = T_world_mount.linear();
  return {T_world_mount.translation(),
          {std::atan2(R(1, 0), R(0, 0)), std::asin(std::clamp(-R(2, 0), -1.0, 1.0)),
           std::atan2(R(2, 1), R(2, 2))}};
}

MountPosition between(const MountPosition& a, const MountPosition& b, double share) {
  return {a.xyz + share * (b.xyz - a.xyz), a.ypr + share * (b.ypr - a.ypr)};
}

std::vector<Eigen::Isometry3d> forward_kinematics(const Description& hand,
                                                  const JointVector& joints) {
  std::vector<Eigen::Isometry3d> T_mount_link;
  T_mount_link.reserve(hand.links.size());
  for (const Link& link : hand.links) {
    Eigen::Isometry3d T = link.T_parent_link;
    if (link.joint >= 0) T.rotate(Eigen::AngleAxisd(joints[link.joint], link.axis));
    T_mount_link.push_back(
        link.parent < 0 ? T : T_mount_link[static_cast<std::size_t>(link.parent)] * T);
  }
  return T_mount_link;
}

Jacobian jacobian(const Description& hand, const JointVector& joints, int link,
                  const Eigen::Vector3d& p_link) {
  const auto T_mount_link = forward_kinematics(hand, joints);
  const Eigen::Vector3d p = T_mount_link.at(static_cast<std::size_t>(link)) * p_link;
  Jacobian J = Jacobian::Zero(6, hand.joint_count());
  for (int i = link; i >= 0; i = hand.links[static_cast<std::size_t>(i)].parent) {
    const Link& moved = hand.links[static_cast<std::size_t>(i)];
    if (moved.joint < 0) continue;
    const auto& T = T_mount_link[static_cast<std::size_t>(i)];
    const Eigen::Vector3d axis = T.linear() * moved.axis;
    J.col(moved.joint).head<3>() = axis;
    J.col(moved.joint).tail<3>() = axis.cross(p - T.translation());
  }
  return J;
}

bool may_be_misplaced(const Link& link) {
  return link.joint >= 0 && !link.T_parent_link.translation().isZero();
}

std::vector<int> misplaced_links(const Description& hand, int link) {
  std::vector<int> misplaced;
  for (int i = link; i >= 0; i = hand.links[static_cast<std::size_t>(i)].parent) {
    if (may_be_misplaced(hand.links[static_cast<std::size_t>(i)])) misplaced.push_back(i);
  }
  return misplaced;
}

Description with_perturbed_links(Description hand, double rms, RandomStream& random) {
  const double sigma = rms / std::sqrt(3.0);
  for (Link& link : hand.links) {
    Eigen::Vector3d offset = sigma * random.normal3();
    if (may_be_misplaced(link)) link.T_parent_link.translation() += offset;
  }
  hand.kinematic_error = rms;
  return hand;
}

ActuatorVector actuator_positions(const Description& hand, const JointVector& joints) {
  ActuatorVector positions(hand.actuator_count());
  for (int i = 0; i < hand.actuator_count(); ++i) {
    positions[i] = 0;
    for (const DrivenJoint& driven : hand.actuators[static_cast<std::size_t>(i)].joints) {
      positions[i] += driven.gear * joints[driven.joint];
    }
  }
  return positions;
}

JointVector joints_in_free_flexion(const Description& hand, const ActuatorVector& positions) {
  JointVector joints = JointVector::Zero(hand.joint_count());
  for (int i = 0; i < hand.actuator_count(); ++i) {
    const Actuator& actuator = hand.actuators[static_cast<std::size_t>(i)];
    if (actuator.coupling) {
      const CoupledAngles pair = share_in_free_flexion(positions[i], *actuator.coupling);
      joints[actuator.joints[0].joint] = pair.j2;
      joints[actuator.joints[1].joint] = pair.j1;
      continue;
    }
    for (const DrivenJoint& driven : actuator.joints) {
      joints[driven.joint] = driven.offset + driven.share * positions[i];
    }
  }
  return joints;
}

CoupledAngles share_in_free_flexion(double j0, const Coupling& coupling) {
  const double both = std::max(0.0, j0 - coupling.follow_angle);
  const double j2 = std::min(j0 - 0.5 * both, coupling.middle_end);
  return {.j1 = j0 - j2, .j2 = j2};
}

double j0_for_middle(double j2, const Coupling& coupling) {
  return j2 + std::max(0.0, j2 - coupling.follow_angle);
}

}  // namespace palpate::hand
