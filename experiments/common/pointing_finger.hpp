// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "palpate/hand/hand.hpp"
#include "palpate/hand/kinematics.hpp"
#include "palpate/hand/shadow.hpp"

namespace palpate::experiment {

/// A hand that holds one finger out and the others away, led by its mount.
class PointingFinger {
 public:
  /// @param finger  index into hand::kShadowFingerNames
  PointingFinger(hand::Description hand, int finger, const hand::ActuatorVector& posture);

  int finger() const { return finger_; }
  const hand::ActuatorVector& posture() const { return posture_; }
  const hand::JointVector& joints() const { return joints_; }
  const hand::Description& hand() const { return hand_; }
  const hand::TipCapsule& tip() const;

  /// Where the finger points, in the mount's frame.
  Eigen::Vector3d direction() const;

  /// The command that brings the centre of the tip's round end (m, world) there.
  hand::HandCommand command(const Eigen::Matrix3d& R_world_mount,
                            const Eigen::Vector3d& center) const;

 private:
  hand::Description hand_;
  int finger_;
  hand::ActuatorVector posture_;
  hand::JointVector joints_;
  Eigen::Isometry3d T_mount_distal_;
};

/// One finger straight, the others curled away; the thumb in some ways, of which it depends on the
/// place which is best.
std::vector<hand::ActuatorVector> pointing_postures(int finger);

/// A straight finger points down.
Eigen::Matrix3d pointing_down();

}  // namespace palpate::experiment
