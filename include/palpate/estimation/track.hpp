// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "palpate/estimation/event_log.hpp"
#include "palpate/localization/tracking/tracker.hpp"
#include "palpate/tactile/contacts/contact_window.hpp"

namespace palpate::estimation {

/// How an object was followed in the hand.
struct Tracked {
  struct Look {
    std::size_t reading;               ///< index into the log
    Eigen::Isometry3d T_mount_object;  ///< heaviest pose
  };
  std::vector<Look> looks;
  localization::Posterior posterior;  ///< at the last look, in the hand's mount
  int slips = 0;                      ///< that were noticed
};

/// Velocities of fingertips are differences of joint angles, which are noisy.
inline localization::TrackerOptions tracking_in_lift() {
  localization::TrackerOptions options;
  options.velocity_noise = 0.004;
  return options;
}

struct TrackOptions {
  double period = 0.1;  ///< s between two looks at the contacts; the readings between are averaged
  localization::TrackerOptions tracker = tracking_in_lift();

  template <class Visitor>
  void visit(Visitor&& v) {
    v("period", period, 0.01, 5.0, "s between two updates from the contacts");
    v.expert_section("tracker", tracker);
  }
};

/// What is tracked: an object in a hand, from one reading of the log to another.
struct TrackInput {
  const geometry::ObjectModel& object;
  const hand::Description& hand;
  const EventLog& log;
  const localization::Posterior& start;  ///< pose at the reading `first`, in the world, with modes
  std::size_t first, last;               ///< indices into the log, both included
  tactile::ContactErrorModel errors = {};
};

/// Tracks an object in the hand by what the fingertips sense and how they move, as a
/// localization::Tracker that ran along would.
/// @param input  is only read, and not kept
/// @throws BadInput unless first <= last, and the log has both
Tracked track(const TrackInput& input, const TrackOptions& options, std::uint64_t seed);

}  // namespace palpate::estimation
