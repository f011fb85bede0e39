// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "palpate/hand/hand.hpp"

namespace palpate::skills {

/// N m that an actuator may press with where its fingertip senses nothing.
/// @param max_force  N at the fingertip
double unsensed_torque(const hand::Actuator& actuator, double max_force);

/// Ends the motion of fingers that something holds up and that sense nothing of it: what their
/// actuators press with is limited, whatever they are commanded. Fingers that sense contact are
/// left alone; they stop by what they sense.
class UnsensedForce {
 public:
  /// @param max_force  N at a fingertip that senses nothing, by the levers of its actuators
  UnsensedForce(const hand::Description& hand, double max_force);

  /// @param command  wanted for this tick; changed where a finger may press no further
  /// @param last  that led to the reading
  /// @return fingers that have been limited for a while
  std::vector<int> limit(hand::HandCommand& command, const hand::HandCommand& last,
                         const hand::HandReading& reading);

 private:
  [[nodiscard]] bool limit(int actuator, hand::HandCommand& command, const hand::HandCommand& last,
                           const hand::HandReading& reading) const;

  hand::Description hand_;
  hand::ActuatorVector max_torques_;  // N m
  hand::PerFinger<int> apart_{};      // readings since a fingertip sensed something
  hand::PerFinger<int> pressed_{};    // ticks in a row in which a finger was limited
};

}  // namespace palpate::skills
