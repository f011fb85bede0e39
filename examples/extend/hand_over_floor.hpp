// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Geometry>
#include <utility>
#include <vector>

#include "palpate/core/random.hpp"
#include "palpate/hand/hand.hpp"
#include "palpate/hand/kinematics.hpp"

namespace palpate::hand {

/// A driver: what the skills know of a hand is its description and this step(). This one moves no
/// hardware. It is at once where it is commanded to be, and senses a floor with the ends of its
/// fingertips.
class HandOverFloor : public Hand {
 public:
  HandOverFloor(Description model, double floor)
      : model_(std::move(model)), floor_(floor), noise_(1, "noise") {}

  HandReading step(const HandCommand& command) override {
    HandReading reading;
    reading.time = ++ticks_ * kTick;
    reading.mount = command.mount;
    reading.joints = joints_in_free_flexion(model_, command.positions);
    for (double& joint : reading.joints) joint += 1e-4 * noise_.normal();  // as of any encoder
    reading.torques = 1e-4 * ActuatorVector::Random(model_.actuator_count());
    reading.mount_force = 0.01 * noise_.normal3();
    reading.contacts.resize(model_.fingers.size());
    const auto links = forward_kinematics(model_, reading.joints);
    for (std::size_t i = 0; i < model_.fingers.size(); ++i) {
      const Finger& finger = model_.fingers[i];
      const Eigen::Isometry3d T_world_link =
          command.mount.pose() * links[static_cast<std::size_t>(finger.link)];
      sense_floor(finger.tip, T_world_link, reading.contacts[i]);
    }
    return reading;
  }

 private:
  /// The floor pushes back with 1 N a millimetre.
  void sense_floor(const TipCapsule& tip, const Eigen::Isometry3d& T_world_link,
                   std::vector<TipContact>& contacts) const {
    const Eigen::Vector3d up = Eigen::Vector3d::UnitZ();
    const Eigen::Vector3d lowest = T_world_link * tip.b - tip.radius * up;
    const double depth = floor_ - lowest.z();
    if (depth <= 0) return;
    const Eigen::Vector3d n = T_world_link.linear().transpose() * up;
    contacts.push_back({T_world_link.inverse() * lowest, n, -1000 * depth * n});
  }

  Description model_;
  double floor_;  // m, height in the world
  RandomStream noise_;
  int ticks_ = 0;
};

}  // namespace palpate::hand
