// SPDX-License-Identifier: Apache-2.0
#include "palpate/recording/touch_log.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <string>
#include <string_view>
#include <utility>

#include "palpate/core/error.hpp"

namespace palpate::recording {
namespace {

constexpr std::string_view kEventPrefix = "mark ";

/// Names in recordings of earlier programs.
constexpr std::array<std::pair<std::string_view, std::string_view>, 3> kFormerNames = {
    {{"felt", "height_probed"}, {"sweep", "guarded_move"}, {"rolled", "probed"}}};

std::string present_name(std::string name) {
  for (const auto& [former, present] : kFormerNames) {
    if (name == former) return std::string(present);
  }
  return name;
}

}  // namespace

std::string touch_note(estimation::TouchEvent event) {
  return std::string(kEventPrefix)
      .append(estimation::kTouchEventNames[static_cast<std::size_t>(event)]);
}

std::optional<estimation::TouchEvent> touch_event_of(const Event& event) {
  if (!event.text.starts_with(kEventPrefix)) return std::nullopt;
  const std::string name = present_name(event.text.substr(kEventPrefix.size()));
  const auto found =
      std::find(estimation::kTouchEventNames.begin(), estimation::kTouchEventNames.end(), name);
  if (found == estimation::kTouchEventNames.end()) {
    throw BadInput(fmt::format("the recording has an event {:?} at {} s, which means nothing here",
                               name, event.time));
  }
  return static_cast<estimation::TouchEvent>(found - estimation::kTouchEventNames.begin());
}

estimation::EventLog event_log(const Recording& recording) {
  estimation::EventLog log;
  for (const auto& frame : recording.frames) log.readings.push_back(frame.reading);
  for (const auto& event : recording.events) {
    const auto touch = touch_event_of(event);
    const auto reading =
        std::find_if(log.readings.begin(), log.readings.end(),
                     [&](const auto& candidate) { return candidate.time >= event.time; });
    if (!touch || reading == log.readings.end()) continue;
    log.moments.push_back({*touch, static_cast<std::size_t>(reading - log.readings.begin())});
  }
  return log;
}

}  // namespace palpate::recording
