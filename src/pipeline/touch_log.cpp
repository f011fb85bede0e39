// SPDX-License-Identifier: Apache-2.0
#include "palpate/pipeline/touch_log.hpp"

#include <algorithm>

namespace palpate::pipeline {

std::vector<TouchLog::Moment> TouchLog::since_release() const {
  const auto release = std::find_if(moments.rbegin(), moments.rend(), [](const Moment& moment) {
    return moment.mark == Mark::released;
  });
  return {release.base(), moments.end()};
}

TouchLog TouchLog::until(Mark mark) const {
  const auto last = std::find_if(moments.rbegin(), moments.rend(),
                                 [&](const Moment& moment) { return moment.mark == mark; });
  if (last == moments.rend()) return *this;
  const auto count = static_cast<std::ptrdiff_t>(last->reading) + 1;
  return {{readings.begin(), readings.begin() + count}, {moments.begin(), last.base()}};
}

std::optional<std::size_t> TouchLog::at(Mark mark) const {
  std::optional<std::size_t> reading;
  for (const Moment& moment : since_release()) {
    if (moment.mark == mark) reading = moment.reading;
  }
  return reading;
}

std::vector<std::size_t> TouchLog::all(Mark mark) const {
  std::vector<std::size_t> all;
  for (const Moment& moment : since_release()) {
    if (moment.mark == mark) all.push_back(moment.reading);
  }
  return all;
}

}  // namespace palpate::pipeline
