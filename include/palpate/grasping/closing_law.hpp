// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "palpate/hand/hand.hpp"

namespace palpate::grasping {

/// Closes fingers at a given speed, never pressing harder than a torque limit.
///
/// Each tick the setpoint advances, but leads the joint by at most torque / stiffness:
/// command = min(setpoint + rate dt, q + torque / stiffness). The lead is taken from the measured
/// torque, stiffness (command - q), so that the noise of the joint readings does not enter.
class ClosingLaw {
 public:
  /// @param rate  rad/s of an actuator that closes at speed 1 (hand::Actuator::closing)
  /// @param closed  rad, where each ends at the latest
  ClosingLaw(const hand::Description& hand, double rate, const hand::ActuatorVector& closed);

  /// Moves the commands of the active fingers by one tick.
  /// @param max_torque  N m, with which each presses at most
  void advance(hand::HandCommand& command, const hand::HandReading& reading,
               const hand::ActuatorVector& max_torque, const hand::PerFinger<bool>& active) const;

 private:
  struct Drive {
    int actuator;
    std::size_t finger;
    double stiffness;
    double rate;       // rad/s, towards closed
    double direction;  // 1 or -1: which way the actuator closes
    hand::Range range;
  };
  std::vector<Drive> drives_;
};

}  // namespace palpate::grasping
