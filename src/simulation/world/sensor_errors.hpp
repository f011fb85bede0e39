// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <deque>

#include "palpate/core/random.hpp"
#include "palpate/hand/hand.hpp"
#include "palpate/simulation/world/world.hpp"

namespace palpate::simulation {

/// What the readings of one hand and arm are off by beside noise (WorldErrors): constant, slowly
/// drifting, or late.
class SensorErrors {
 public:
  /// @param weight  of the hand, N
  SensorErrors(const WorldOptions& options, const hand::Description& hand, double weight,
               const RandomStream& random);

  /// Where the mount comes that the arm is commanded to move there: it does not know the table's
  /// height.
  [[nodiscard]] hand::MountPosition in_world(hand::MountPosition mount) const;

  /// Where the drives come that are commanded to go there: their zeros are off.
  [[nodiscard]] hand::ActuatorVector in_drives(const hand::ActuatorVector& positions) const;

  /// Makes a reading of the true load and torques, the true mount and joints into what is read.
  void misread(hand::HandReading& reading);

  /// Adds to a contact of a fingertip the errors that its sensor has beside white noise; to be
  /// called after misread().
  /// @return false if it is not sensed: it would pull
  bool misread(std::size_t finger, hand::TipContact& contact) const;

  /// Noise of contacts that is independent from reading to reading.
  [[nodiscard]] SensorNoise white_noise() const;

  /// Gives a reading the pose of the mount and the contacts of a while ago.
  void delay(hand::HandReading& reading, RandomStream& random);

  void reset();

 private:
  /// What the contacts of a fingertip have in common.
  struct TouchError {
    double radius = 0;                                // m, outwards
    Eigen::Vector3d offset;                           // m, in the frame of the tip's link
    Eigen::Vector3d point = Eigen::Vector3d::Zero();  // m, changes slowly
    Eigen::Vector2d tilt = Eigen::Vector2d::Zero();   // rad, changes slowly
  };

  void misread_torques(hand::HandReading& reading);
  void drift_touch(std::uint64_t tick);

  SensorNoise noise_;
  double table_height_ = 0;                              // m
  Eigen::Vector3d load_bias_, load_drift_;               // N, N/s, in the mount's frame
  double load_weight_ = 0;                               // N, upwards
  hand::ActuatorVector torque_scale_, torque_friction_;  // -, N m
  hand::ActuatorVector slipped_;                         // share of the friction, -1..1
  hand::ActuatorVector last_positions_;                  // rad
  hand::JointVector joint_zero_;                         // rad
  hand::ActuatorVector drive_zero_;                      // rad
  std::vector<TouchError> touches_;                      // one a finger
  RandomStream touch_random_;
  hand::Description hand_;
  std::deque<hand::MountPosition> mounts_;
  std::deque<std::vector<std::vector<hand::TipContact>>> contacts_;
};

}  // namespace palpate::simulation
