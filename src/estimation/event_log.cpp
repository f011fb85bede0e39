// SPDX-License-Identifier: Apache-2.0
#include "palpate/estimation/event_log.hpp"

#include <algorithm>

namespace palpate::estimation {

std::vector<EventLog::Moment> EventLog::since_release() const {
  const auto release = std::find_if(moments.rbegin(), moments.rend(), [](const Moment& moment) {
    return moment.event == TouchEvent::released;
  });
  return {release.base(), moments.end()};
}

std::size_t EventLog::count(TouchEvent event) const {
  const auto moments_held = since_release();
  return static_cast<std::size_t>(
      std::count_if(moments_held.begin(), moments_held.end(),
                    [event](const Moment& moment) { return moment.event == event; }));
}

std::vector<EventLog::Moment> EventLog::since_opening() const {
  const auto moments_held = since_release();
  const auto opening =
      std::find_if(moments_held.rbegin(), moments_held.rend(),
                   [](const Moment& moment) { return moment.event == TouchEvent::opened; });
  return {opening.base(), moments_held.end()};
}

std::optional<EventLog> EventLog::before_opening() const {
  const std::size_t since = since_opening().size();
  if (since == since_release().size()) return std::nullopt;
  const auto opening = moments.end() - static_cast<std::ptrdiff_t>(since) - 1;
  const auto count = static_cast<std::ptrdiff_t>(opening->reading) + 1;
  return EventLog{
      {readings.begin(), readings.begin() + count}, {moments.begin(), opening}, T_world_table};
}

EventLog EventLog::until(TouchEvent event) const {
  const auto last = std::find_if(moments.rbegin(), moments.rend(),
                                 [&](const Moment& moment) { return moment.event == event; });
  if (last == moments.rend()) return *this;
  const auto count = static_cast<std::ptrdiff_t>(last->reading) + 1;
  return {
      {readings.begin(), readings.begin() + count}, {moments.begin(), last.base()}, T_world_table};
}

std::optional<std::size_t> EventLog::at(TouchEvent event) const {
  std::optional<std::size_t> reading;
  for (const Moment& moment : since_opening()) {
    if (moment.event == event) reading = moment.reading;
  }
  return reading;
}

bool EventLog::hangs_at(std::size_t reading) const {
  bool hangs = false;
  for (const Moment& moment : since_opening()) {
    if (moment.reading > reading) break;
    if (moment.event == TouchEvent::held) hangs = true;
    if (moment.event == TouchEvent::closed || moment.event == TouchEvent::placed) hangs = false;
  }
  return hangs;
}

std::vector<std::size_t> EventLog::all(TouchEvent event) const {
  std::vector<std::size_t> all;
  for (const Moment& moment : since_opening()) {
    if (moment.event == event) all.push_back(moment.reading);
  }
  return all;
}

}  // namespace palpate::estimation
