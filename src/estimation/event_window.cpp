// SPDX-License-Identifier: Apache-2.0
#include "estimation/event_window.hpp"

#include <algorithm>
#include <cmath>

namespace palpate::estimation {
namespace {

/// How long the hand has stood still at an event, s.
double duration_of(TouchEvent event, const EstimationOptions& options) {
  switch (event) {
    case TouchEvent::touched:
      return 0.1;  // of a guarded move, which ends in it
    case TouchEvent::held:
      return options.window;
    default:
      return 0.15;  // fingers that have closed or probed
  }
}

}  // namespace

std::span<const hand::HandReading> window_before(const EventLog& log, std::size_t index,
                                                 double seconds) {
  const auto count =
      std::min(index + 1, static_cast<std::size_t>(std::ceil(seconds / hand::kTick)));
  return std::span(log.readings).subspan(index + 1 - count, count);
}

std::span<const hand::HandReading> event_window(const EventLog& log, TouchEvent event,
                                                std::size_t reading,
                                                const EstimationOptions& options) {
  return window_before(log, reading, duration_of(event, options));
}

}  // namespace palpate::estimation
