// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "palpate/planning/trajectory.hpp"

namespace palpate::planning {

/// How far the hand was from where it was commanded to be, in the coordinates that move.
struct TrackingError {
  double joint_rms = 0, joint_max = 0;  ///< rad, of the actuators
  double base_rms = 0, base_max = 0;    ///< m, of the base's place
  double turn_rms = 0, turn_max = 0;    ///< rad, of the base's angles
  std::vector<Coordinates> measured;    ///< one a sample
};

struct ExecutionOptions {
  double base_lead = 0.06325;  ///< s, how late the base's drives follow: damping over stiffness

  template <class Visitor>
  void visit(Visitor&& v) {
    v("base_lead", base_lead, 0.0, 1.0, "s, lead of the commanded base pose");
  }
};

/// Sends the samples to the hand's position controllers, one a tick, and measures how well they
/// follow. The base, whose drives are late by a constant time, gets its commands as much earlier.
/// The hand must be at the first sample; none leave nothing to measure.
TrackingError execute(hand::Hand& hand, const hand::Description& model,
                      const std::vector<hand::HandCommand>& samples,
                      const ExecutionOptions& options = {});

}  // namespace palpate::planning
