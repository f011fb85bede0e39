// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "palpate/estimation/estimate.hpp"

namespace palpate::estimation {

/// The posterior as an event left it.
struct PosteriorStep {
  EventLog::Moment moment;
  localization::Posterior posterior;  ///< in the world
};

/// How the posterior of the pose went from event to event: of the resting object after each touch
/// and each guarded move that touched nothing, of the object in the hand when the fingers had
/// closed and when it hung. One search an event, each from what the log holds up to it and nothing
/// later, so that the steps are those that the robot acted upon.
/// @param hand  as it was calibrated when the object was touched
/// @return in the order of time; until the hand lets go of the object
std::vector<PosteriorStep> posterior_history(PoseEstimator& estimator,
                                             const hand::Description& hand, const EventLog& log);

}  // namespace palpate::estimation
