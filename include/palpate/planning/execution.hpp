// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "palpate/planning/trajectory.hpp"

namespace palpate::planning {

/// How far the hand was from where it was commanded to be, in the coordinates that move.
struct TrackingError {
  double joint_rms = 0, joint_max = 0;  ///< rad, of the actuators
  double mount_rms = 0, mount_max = 0;  ///< m, of the mount's place
  double turn_rms = 0, turn_max = 0;    ///< rad, of the mount's angles
  std::vector<Coordinates> measured;    ///< one a sample
};

struct ExecutionOptions {
  double mount_lead = 0.06325;  ///< s, how late the mount's drives follow: damping over stiffness

  template <class Visitor>
  void visit(Visitor&& v) {
    v("mount_lead", mount_lead, 0.0, 1.0, "s, lead of the commanded mount pose");
  }
};

/// Sends the samples to the hand's position controllers, one a tick, and measures how well they
/// follow. The mount, whose drives are late by a constant time, gets its commands as much earlier.
/// The hand must be at the first sample; none leave nothing to measure.
TrackingError execute(hand::Hand& hand, const hand::Description& model,
                      const std::vector<hand::HandCommand>& samples,
                      const ExecutionOptions& options = {});

}  // namespace palpate::planning
