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
    std::size_t reading;              ///< index into the log
    Eigen::Isometry3d T_base_object;  ///< heaviest pose
  };
  std::vector<Look> looks;
  localization::Posterior posterior;  ///< at the last look, in the hand's base
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

/// Follows an object in the hand by what the fingertips sense and how they move, from the reading
/// `first` of the log to `last`, as a localization::Tracker that ran along would.
/// @param errors  of the contacts
/// @param start   pose at the first reading, in the world, with modes
/// @throws BadInput unless first <= last, and the log has both
Tracked track(const geometry::ObjectModel& object, const hand::Description& hand,
              const EventLog& log, const tactile::ContactErrorModel& errors,
              const localization::Posterior& start, std::size_t first, std::size_t last,
              const TrackOptions& options, std::uint64_t seed);

}  // namespace palpate::estimation
