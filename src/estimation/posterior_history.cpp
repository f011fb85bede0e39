// SPDX-License-Identifier: Apache-2.0
#include "palpate/estimation/posterior_history.hpp"

#include <algorithm>

namespace palpate::estimation {

std::vector<PosteriorStep> posterior_history(PoseEstimator& estimator,
                                             const hand::Description& hand, const EventLog& log) {
  std::vector<PosteriorStep> steps;
  EventLog past;
  for (const EventLog::Moment& moment : log.moments) {
    if (moment.event == TouchEvent::released) break;
    const auto known = static_cast<std::ptrdiff_t>(past.readings.size());
    const auto end = std::max(known, static_cast<std::ptrdiff_t>(moment.reading) + 1);
    past.readings.insert(past.readings.end(), log.readings.begin() + known,
                         log.readings.begin() + end);
    past.moments.push_back(moment);
    if (ends_guarded_move(moment.event)) {
      steps.push_back({moment, estimator.resting(hand, past)});
    } else if (is_grasp(moment.event)) {
      steps.push_back({moment, estimator.held(hand, past, moment.reading).posterior});
    }
  }
  return steps;
}

}  // namespace palpate::estimation
