// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "palpate/core/progress.hpp"
#include "palpate/estimation/online_tracker.hpp"
#include "palpate/recording/recording.hpp"
#include "palpate/skills/explore/explore_phase.hpp"
#include "palpate/tasks/relocate/relocate_touch.hpp"
#include "palpate/tasks/relocate/rollout.hpp"

namespace palpate::relocate {

/// How a policy of the relocate task learns where the object is (thesis chapter 7 is given it).
struct RelocationOptions {
  bool explore = true;  ///< the resting object is touched first, else only `uncertainty` known
  double uncertainty = 0.02;  ///< m, within which the object's place is known at first, in x and y
  estimation::OnlineTrackerOptions tracking;
  /// The task's arm cannot turn the hand round, and its light fingers bounce off at higher speeds.
  skills::ExploreOptions exploring = {.turn = 0.5, .touch_speed = 0.015};
  estimation::EstimationOptions resting;  ///< how the pose on the table is estimated
  simulation::SensorNoise noise;

  template <class Visitor>
  void visit(Visitor&& v) {
    v("explore", explore,
      "explore the resting object first; else only its approximate position is known");
    v("uncertainty", uncertainty, 0.0, 0.2,
      "m, the object is within +- this of its approximate position");
    v.section("tracking", tracking);
    v.section("exploring", exploring);
    v.section("resting", resting);
    v.section("noise", noise);
  }
};

/// An episode in which the policy was given the pose estimated by touch.
struct TouchEpisode {
  Episode episode;
  double resting_error = 0;     ///< m, of the initial place that it was given, in x and y
  double reported_error = 0;    ///< m, in the last step
  bool explored = false;        ///< the pose of the resting object was estimated by touch
  std::string exploration;      ///< how exploring ended, in one line
  int explore_steps = 0;        ///< of 10 ms, that exploring took
  int estimates = 0;            ///< of the pose in the grasp
  double estimate_seconds = 0;  ///< wall time of one, mean; 0 without any
};

/// @throws BadInput for errors of an observed position, where the policy gets the estimated one
void check_by_touch(const EpisodeOptions& episode);

/// The relocate task with a policy that gets the object's place as estimated by touch, never the
/// true one: the transport phase of thesis chapter 7 behind the estimation of chapter 6.
///
/// Before it reaches out, the task's own hand explores the resting object with a finger; while it
/// closes and carries, the pose is estimated from the fingertips of the Adroit hand
/// (OnlineTracker).
class Relocation {
 public:
  /// @throws BadInput for an object that cannot be used, or does not stand on its own at the start
  Relocation(const TaskOptions& task, const RelocationOptions& options);

  /// Episode i starts as rollout starts it.
  /// @throws BadInput as check_by_touch
  /// @param recording  filled if not null: what the Adroit hand senses, the estimates, first that
  ///        of the resting object, and the truth; without the configuration
  TouchEpisode run(const Policy& policy, const EpisodeOptions& episode, std::uint64_t seed,
                   std::size_t index, recording::Recording* recording = nullptr) const;

  /// `count` episodes on up to `threads` threads.
  std::vector<TouchEpisode> run_all(const Policy& policy, const EpisodeOptions& episode,
                                    std::uint64_t seed, std::size_t count, int threads,
                                    const ProgressCallback& progress = {}) const;

 private:
  localization::Posterior rough(const Eigen::Vector2d& place, RandomStream random) const;
  Eigen::Vector2d rough_place(const RelocateStart& start, RandomStream random) const;

  RelocationOptions options_;
  RelocateObject shape_;
  RelocateModel model_;
  geometry::ObjectModel object_;  ///< its one stable pose is that in which it starts
};

}  // namespace palpate::relocate
