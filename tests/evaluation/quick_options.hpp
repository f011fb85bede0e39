// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "palpate/evaluation/trial.hpp"

namespace palpate::evaluation {

/// A pick that takes a few seconds of wall time.
inline TrialOptions quick_options() {
  TrialOptions options = TrialOptions::ideal();
  options.pick.explore.touches = 4;
  options.pick.lift.hold = 0.5;
  options.pick.palpation.max = 2;
  options.pick.palpation.regrasps = 0;
  options.pick.palpation.certain = options.pick.palpation.doubtful = 1;  // whatever is known
  options.pick.palpation.table_touches = 0;
  options.pick.palpation.min_gain_rate = 0;
  options.pick.estimation.search.proposals = 20000;
  options.pick.estimation.search.particles = 400;
  return options;
}

/// Picking and placing that takes a few seconds of wall time.
inline TrialOptions quick_place_options() {
  TrialOptions options = TrialOptions::ideal();
  options.pick.calibrate.touches = 0;
  options.pick.explore.touches = options.pick.explore.max_touches = 4;
  options.pick.lift.hold = 0.5;
  options.pick.estimation.search.proposals = 20000;
  options.pick.estimation.search.particles = 400;
  options.start.stable_pose = 0;
  options.place.target = "0.15,0.1,0.5";
  // A quick search is sure of little.
  options.place.certain = options.place.regrasp.certain_between = 0.3;
  return options;
}

}  // namespace palpate::evaluation
