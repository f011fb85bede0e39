// SPDX-License-Identifier: Apache-2.0
#include "palpate/estimation/posterior_history.hpp"

#include <algorithm>

namespace palpate::estimation {
namespace {

bool is_guarded_move(TouchEvent event) {
  return event == TouchEvent::touched || event == TouchEvent::missed;
}

bool is_grasp(TouchEvent event) { return event == TouchEvent::closed || event == TouchEvent::held; }

}  // namespace

std::vector<PosteriorStep> posterior_history(PoseEstimator& estimator,
                                             const hand::Description& hand, const EventLog& log) {
  std::vector<PosteriorStep> steps;
  EventLog past;
  for (const EventLog::Moment& moment : log.moments) {
    if (moment.mark == TouchEvent::released) break;
    const auto known = static_cast<std::ptrdiff_t>(past.readings.size());
    const auto end = std::max(known, static_cast<std::ptrdiff_t>(moment.reading) + 1);
    past.readings.insert(past.readings.end(), log.readings.begin() + known,
                         log.readings.begin() + end);
    past.moments.push_back(moment);
    if (is_guarded_move(moment.mark)) {
      steps.push_back({moment, estimator.resting(hand, past)});
    } else if (is_grasp(moment.mark)) {
      steps.push_back({moment, estimator.held(hand, past, moment.reading).posterior});
    }
  }
  return steps;
}

}  // namespace palpate::estimation
