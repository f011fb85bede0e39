// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <map>
#include <memory>
#include <optional>

#include "palpate/evaluation/trial.hpp"

namespace palpate::evaluation {

/// Errors of several trials.
struct ErrorSummary {
  std::vector<double> rotation_deg, translation_mm;
};

/// What became of placing, over all trials of an object.
struct PlaceSummary {
  std::size_t certain = 0;                            ///< held, and known well enough to place
  std::size_t placed = 0;                             ///< within 5 deg and 10 mm of the target
  std::size_t tight = 0;                              ///< within 3 deg and 5 mm
  std::size_t certain_placed = 0, certain_tight = 0;  ///< these, of the certain
  std::size_t wrong = 0;  ///< certain, let go at the target, and not `placed`
  std::size_t dropped = 0;
  std::size_t in_stable_pose = 0;  ///< the target's side is up at the end, wherever it stands
  std::map<std::string, std::size_t> status;  ///< how it ended, of the trials with a held object
  ErrorSummary final_error;     ///< of the trials in which it was let go at the target
  ErrorSummary estimate_error;  ///< of these: where it stood before, from where believed
  ErrorSummary release_motion;  ///< of these: by which letting go moved it
};

/// A phase over all trials.
struct PhaseSummary {
  std::size_t runs = 0, ok = 0;
  std::vector<double> robot_seconds, wall_seconds;  ///< one a run
};

/// What became of one object's trials. Rates are over all trials started.
struct ObjectSummary {
  std::size_t trials = 0;
  std::size_t lifted = 0;
  std::size_t object_ok = 0;             ///< lifted, and the best pose of the right object
  std::size_t object_certain = 0;        ///< lifted, which object stated with more than 0.95
  std::size_t object_certain_ok = 0;     ///< these, and right
  std::size_t pose_ok = 0;               ///< lifted, and the best pose within 5 deg and 10 mm
  std::size_t lifted_at_once = 0;        ///< at the first attempt
  std::size_t pose_tight = 0;            ///< lifted, and the best pose within 2.5 deg and 3.5 mm
  std::size_t pose_ok_before_lift = 0;   ///< lifted, and the best pose in the closed hand right
  std::size_t pose_ok_before_probe = 0;  ///< lifted, and so before the probes
  std::size_t pose_ok_tracked = 0;       ///< lifted, and the pose followed from there right
  std::size_t probed = 0;                ///< lifted, and probed before
  std::size_t confident_wrong = 0;       ///< the best pose wrong, its probability above 0.9
  std::size_t covered = 0;               ///< lifted, and the truth among the modes
  std::size_t certain = 0;               ///< lifted, and the pose said to be certain
  std::vector<double> modes;             ///< how many, of lifted trials with a pose
  std::vector<double> robot_seconds;     ///< of all trials, from start to end
  std::vector<double> probability;       ///< of the best pose, of lifted trials with one
  std::size_t false_hold = 0;            ///< reported as held, but not lifted
  std::vector<double> rotation_error_deg, translation_error_mm, slip_mm;  ///< of lifted trials
  std::vector<double> tip_force, explored_motion_mm;  ///< N, mm, of lifted trials
  std::map<std::string, std::size_t> failures;  ///< by the phase that failed; "slip" if lost later
  std::size_t symmetry_order = 1;
  PlaceSummary place;
  std::map<std::string, PhaseSummary> phases;
};

void add_trial(const Trial& trial, ObjectSummary& summary);

/// An object of an evaluation, and which of its trials are run.
struct EvaluatedObject {
  const geometry::KnownObject* known;
  std::vector<std::size_t> numbers;  ///< of trials, ascending
  /// Prepared for the search; none: when its first trial begins, and let go of with its last.
  const geometry::ObjectModel* model = nullptr;
};

/// A trial of an evaluation.
struct TrialId {
  std::size_t object, number;
};

/// The callbacks of an evaluation; what is empty is left out. `trial` and `object` are called in
/// the order of objects and numbers, one at a time; the others by any thread.
struct EvaluationHooks {
  /// A trial that was finished before; nothing if it is to be run.
  std::function<std::optional<Trial>(TrialId)> finished = {};
  /// Receives the recording of a trial while it runs; none: nothing does.
  std::function<std::shared_ptr<recording::Sink>(TrialId)> sink = {};
  std::function<void(TrialId, const Trial&)> trial = {};  ///< one has finished
  /// All trials of one have.
  std::function<void(std::size_t object, const ObjectSummary&)> object = {};
};

/// 0, 1, ... count - 1.
std::vector<std::size_t> trial_numbers(std::size_t count);

/// Repeats the picks of objects, each with the seeds first_seed + number.
///
/// The results are the same for any number of threads, and however many trials were finished
/// before.
/// @param candidates  that the robot is given, of which the object may be one; empty: the object
void evaluate(const std::vector<EvaluatedObject>& objects, const TrialOptions& options,
              std::uint64_t first_seed, int threads, const EvaluationHooks& hooks,
              const estimation::Candidates& candidates = {});

}  // namespace palpate::evaluation
