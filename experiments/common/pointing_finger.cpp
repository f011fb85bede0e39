// SPDX-License-Identifier: Apache-2.0
#include "pointing_finger.hpp"

#include <cmath>
#include <string>
#include <utility>

#include "palpate/hand/kinematics.hpp"
#include "palpate/hand/shadow.hpp"

namespace palpate::experiment {
namespace {

constexpr int kThumb = static_cast<int>(hand::FingerName::thumb);
constexpr double kPitch = 1.35;  // rad of the mount: a straight finger points down

/// Yaw, pitch, roll of R = Rz(yaw) Ry(pitch) Rx(roll).
Eigen::Vector3d ypr_of(const Eigen::Matrix3d& R) {
  return {std::atan2(R(1, 0), R(0, 0)), std::atan2(-R(2, 0), std::hypot(R(0, 0), R(1, 0))),
          std::atan2(R(2, 1), R(2, 2))};
}

}  // namespace

PointingFinger::PointingFinger(hand::Description hand, int finger,
                               const hand::ActuatorVector& posture)
    : hand_(std::move(hand)),
      finger_(finger),
      posture_(posture),
      joints_(hand::joints_in_free_flexion(hand_, posture)) {
  const int distal = hand_.fingers[static_cast<std::size_t>(finger)].link;
  T_mount_distal_ = hand::forward_kinematics(hand_, joints_)[static_cast<std::size_t>(distal)];
}

const hand::TipCapsule& PointingFinger::tip() const {
  return hand_.fingers[static_cast<std::size_t>(finger_)].tip;
}

Eigen::Vector3d PointingFinger::direction() const {
  return T_mount_distal_.linear() * (tip().b - tip().a).normalized();
}

hand::HandCommand PointingFinger::command(const Eigen::Matrix3d& R_world_mount,
                                          const Eigen::Vector3d& center) const {
  hand::HandCommand command;
  command.positions = posture_;
  command.mount.ypr = ypr_of(R_world_mount);
  command.mount.xyz = center - R_world_mount * (T_mount_distal_ * tip().b);
  return command;
}

std::vector<hand::ActuatorVector> pointing_postures(int finger) {
  hand::ActuatorVector posture = hand::ActuatorVector::Zero(hand::kShadowActuators);
  for (int other = 1; other < hand::kShadowFingers; ++other) {
    if (other == finger) continue;
    const std::string name(hand::kShadowFingerNames[static_cast<std::size_t>(other)]);
    posture[hand::shadow_hand().actuator(name + "J3")] = 1.4;
    posture[hand::shadow_hand().actuator(name + "J0")] = 2.6;
  }
  posture[hand::shadow_hand().actuator("THJ5")] = -1.0;
  posture[hand::shadow_hand().actuator("THJ2")] = -0.6;
  if (finger != kThumb) return {posture};
  std::vector<hand::ActuatorVector> postures;
  for (const double opposition : {-1.0, 0.0, 1.0}) {
    for (const double abduction : {0.0, 0.6, 1.2}) {
      posture[hand::shadow_hand().actuator("THJ5")] = opposition;
      posture[hand::shadow_hand().actuator("THJ4")] = abduction;
      posture[hand::shadow_hand().actuator("THJ2")] = 0;
      postures.push_back(posture);
    }
  }
  return postures;
}

Eigen::Matrix3d pointing_down() {
  return Eigen::AngleAxisd(kPitch, Eigen::Vector3d::UnitY()).toRotationMatrix();
}

}  // namespace palpate::experiment
