// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "palpate/localization/tracking/tracker.hpp"
#include "palpate/skills/phase.hpp"

namespace palpate::skills {

/// Velocities of fingertips are differences of joint angles, which are noisy.
inline localization::TrackerOptions tracking_in_lift() {
  localization::TrackerOptions options;
  options.velocity_noise = 0.004;
  return options;
}

struct TrackOptions {
  double look = 0.1;  ///< s between two looks at the contacts; the readings between are averaged
  localization::TrackerOptions tracker = tracking_in_lift();

  template <class Visitor>
  void visit(Visitor&& v) {
    v("look", look, 0.01, 5.0, "s between two looks at the contacts");
    v.expert_section("tracker", tracker);
  }
};

/// Follows an object in the hand by what the fingertips feel and how they move, from the reading
/// `first` of the log to `last`, as a localization::Tracker that ran along would.
/// @param errors  of the contacts
/// @param start   pose at the first reading, in the world, with modes
/// @throws BadInput unless first <= last, and the log has both
Tracked track(const geometry::ObjectModel& object, const hand::Description& hand,
              const estimation::EventLog& log, const tactile::ContactErrorModel& errors,
              const localization::Posterior& start, std::size_t first, std::size_t last,
              const TrackOptions& options, std::uint64_t seed);

/// Follows the object from the closed hand through the lift, from the state's estimate on.
class TrackPhase : public Phase {
 public:
  TrackPhase(const geometry::ObjectModel& object, const TrackOptions& options,
             const tactile::ContactErrorModel& errors, std::uint64_t seed)
      : object_(object), options_(options), errors_(errors), seed_(seed) {}
  std::string_view name() const override { return "track"; }
  double time_limit() const override { return 1.0; }
  PhaseEnd run(Executor& robot, PickState& state) override;

 private:
  const geometry::ObjectModel& object_;
  TrackOptions options_;
  tactile::ContactErrorModel errors_;
  std::uint64_t seed_;
};

}  // namespace palpate::skills
