// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <map>

#include "palpate/pipeline/trial.hpp"

namespace palpate::pipeline {

/// What became of one object's trials. Rates are over all trials started.
struct ObjectSummary {
  std::size_t trials = 0;
  std::size_t lifted = 0;
  std::size_t pose_ok = 0;              ///< lifted, and the best pose within 5 deg and 10 mm
  std::size_t lifted_at_once = 0;       ///< at the first attempt
  std::size_t pose_tight = 0;           ///< lifted, and the best pose within 2.5 deg and 3.5 mm
  std::size_t pose_ok_before_lift = 0;  ///< lifted, and the best pose in the closed hand right
  std::size_t sure_but_wrong = 0;       ///< lifted, the best pose wrong, its weight at least .9
  std::size_t truth_in_modes = 0;       ///< lifted, and the truth among the modes
  std::size_t false_hold = 0;           ///< reported as held, but not lifted
  double modes_median = 0;              ///< of the trials with a pose
  std::vector<double> rotation_error_deg, translation_error_mm, slip_mm;  ///< of lifted trials
  std::vector<double> tip_force, explored_motion_mm;  ///< N, mm, of lifted trials
  std::map<std::string, std::size_t> failures;  ///< by the phase that failed; "slip" if lost later
  std::size_t symmetry_order = 1;
};

/// Told of each finished trial, in the order of the seeds.
using TrialObserver = std::function<void(std::size_t done, const Trial& trial)>;

/// Repeats the pick of one object with the seeds first_seed, first_seed + 1, ...
///
/// The result is the same for any number of threads.
ObjectSummary evaluate(const localization::ObjectModel& object, const TrialOptions& options,
                       std::uint64_t first_seed, std::size_t trials, int threads,
                       const TrialObserver& observer = {});

}  // namespace palpate::pipeline
