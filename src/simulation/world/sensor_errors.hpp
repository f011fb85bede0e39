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

  /// Where the base comes that the arm is commanded to move there: it does not know the table's
  /// height.
  [[nodiscard]] hand::BasePosition in_world(hand::BasePosition base) const;

  /// Makes a reading of the true load and torques, the true base and joints into what is read.
  void misread(hand::HandReading& reading);

  /// Gives a reading the pose of the mount and the contacts of a while ago.
  void delay(hand::HandReading& reading, RandomStream& random);

  void reset();

 private:
  void misread_torques(hand::HandReading& reading);

  SensorNoise noise_;
  double table_height_ = 0;                              // m
  Eigen::Vector3d load_bias_, load_drift_;               // N, N/s, in the mount's frame
  double load_weight_ = 0;                               // N, upwards
  hand::ActuatorVector torque_scale_, torque_friction_;  // -, N m
  hand::ActuatorVector slipped_;                         // share of the friction, -1..1
  hand::ActuatorVector last_positions_;                  // rad
  hand::Description hand_;
  std::deque<hand::BasePosition> bases_;
  std::deque<std::vector<std::vector<hand::TipContact>>> contacts_;
};

}  // namespace palpate::simulation
