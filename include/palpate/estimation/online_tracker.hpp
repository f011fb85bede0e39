// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <vector>

#include "palpate/estimation/estimate.hpp"
#include "palpate/localization/localizer.hpp"

namespace palpate::estimation {

/// A search that is over in a fraction of a second: what is looked for is mostly known.
inline EstimationOptions estimation_in_motion() {
  EstimationOptions options;
  options.search.proposals = 10000;
  options.search.particles = 200;
  options.search.moves = 4;
  options.search.starts = 60;
  options.window = 0.05;
  return options;
}

/// One that takes less time than OnlineTrackerOptions::period.
inline EstimationOptions estimation_of_tracker() {
  EstimationOptions options = estimation_in_motion();
  options.search.proposals = 1000;
  options.search.particles = 60;
  options.search.starts = 20;
  return options;
}

/// How an object is followed by touch from the table into a moving grasp.
struct OnlineTrackerOptions {
  bool estimate = true;         ///< in the grasp, else the object is taken to go with the palm
  double period = 0.05;         ///< s from one estimate to the next, and until it is there
  int fingers = 2;              ///< that must touch for an estimate
  double lifts = 0.005;         ///< m that the palm has risen: what the hand touches goes along
  double rotation_sigma = 0.2;  ///< rad, by which the object turns unforeseen in a period, per axis
  double translation_sigma = 0.008;  ///< m, by which it moves so
  EstimationOptions estimation = estimation_of_tracker();

  template <class Visitor>
  void visit(Visitor&& v) {
    v("estimate", estimate,
      "estimate the pose in the grasp; else the object is assumed to move with the palm");
    v("period", period, 0.01, 10.0, "s, time between two estimates, and delay of each");
    v("fingers", fingers, 1, 5, "number of fingers that must touch for an estimate");
    v("lifts", lifts, 0.0, 0.1,
      "m, rise of the palm after which the touched object is assumed to move with it");
    v("rotation_sigma", rotation_sigma, 1e-4, 3.0,
      "rad, unpredicted rotation of the object per period");
    v("translation_sigma", translation_sigma, 1e-5, 0.2,
      "m, unpredicted translation of the object per period");
    v.section("estimation", estimation);
  }
};

/// Where a hand believes the object to be while it reaches for it, grasps it and carries it: by
/// what is known beforehand, by what its fingertips sense, and by its own motion.
///
/// Every `period` the pose is estimated from the fingertips' contacts and the space that the hand
/// takes; before them the object has either stayed where it was or gone with the palm since the
/// hand touched it. As it takes its time, an estimate is there one period later. Meanwhile the
/// object is taken to go with the palm if the hand has risen and touches it.
class OnlineTracker {
 public:
  /// Keeps references to object and hand.
  /// @param resting  pose on the table, in the world
  /// @throws BadInput for a pose without modes
  OnlineTracker(const geometry::ObjectModel& object, const hand::Description& hand,
                const localization::Posterior& resting, const OnlineTrackerOptions& options,
                std::uint64_t seed);

  /// Called with every reading, one a tick.
  void update(const hand::HandReading& reading);

  Eigen::Isometry3d T_world_object() const;     ///< at the last reading
  int estimates() const { return estimates_; }  ///< that were made
  /// The last of them, used one period after the reading that it is of; before the first, the pose
  /// on the table.
  const HeldPoseEstimate& newest() const { return coming_.pose; }
  double seconds() const { return seconds_; }  ///< of wall time, that they took together

 private:
  struct Estimate {
    HeldPoseEstimate pose;
    std::size_t reading = 0;  ///< that it is of
  };
  [[nodiscard]] localization::PosePrior expected() const;
  void follow();
  void estimate();

  const geometry::ObjectModel& object_;
  const hand::Description& hand_;
  OnlineTrackerOptions options_;
  RandomStream random_;
  EventLog log_;
  std::vector<Eigen::Isometry3d> palm_;   ///< in the world, at each reading
  std::vector<Eigen::Isometry3d> moved_;  ///< by which the object has moved in the world since 0
  double lowest_palm_ = 0;                ///< m, so far
  std::optional<std::size_t> touched_;    ///< first reading with a contact
  Estimate known_, coming_;
  int estimates_ = 0;
  double seconds_ = 0;
};

}  // namespace palpate::estimation
