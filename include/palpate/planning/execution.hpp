// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "palpate/planning/trajectory.hpp"

namespace palpate::planning {

/// How far the hand was from where it was told to be, in the coordinates that move.
struct TrackingError {
  double joint_rms = 0, joint_max = 0;  ///< rad, of the actuators
  double base_rms = 0, base_max = 0;    ///< m, of the base's place
  double turn_rms = 0, turn_max = 0;    ///< rad, of the base's angles
  std::vector<Coordinates> measured;    ///< one a sample
};

/// Sends the samples to the hand's position controllers, one a tick, and measures how well they
/// follow. The hand must be at the first sample; none leave nothing to measure.
TrackingError execute(hand::Hand& hand, const std::vector<hand::HandCommand>& samples);

}  // namespace palpate::planning
