// SPDX-License-Identifier: Apache-2.0
#include "tactile/biotac/folds.hpp"

#include <algorithm>

namespace palpate::tactile {
namespace {

constexpr std::size_t kMinSamples = 10;

std::vector<std::vector<BiotacSample>> touches_of(const std::vector<BiotacLog>& logs) {
  std::vector<std::vector<BiotacSample>> touches;
  for (const BiotacLog& log : logs) {
    const BiotacSignals signals = biotac_signals(log);
    bool touching = false;
    for (std::size_t i = 0; i < log.time.size(); ++i) {
      const bool usable = biotac_usable(signals.flags[i]) && log.normals[i].has_value();
      if (usable && !touching) touches.emplace_back();
      if (usable) touches.back().push_back({signals.changes[i], *log.normals[i]});
      touching = usable;
    }
  }
  return touches;
}

}  // namespace

std::vector<BiotacFold> folds_of_touches(const std::vector<BiotacLog>& logs, int folds) {
  const auto touches = touches_of(logs);
  std::size_t total = 0;
  for (const auto& touch : touches) total += touch.size();
  std::vector<BiotacFold> result;
  for (int fold = 0; fold < folds; ++fold) {
    BiotacFold parts;
    std::size_t before = 0;
    for (const auto& touch : touches) {
      const std::size_t middle = before + touch.size() / 2;
      const bool left_out = static_cast<int>(middle * static_cast<std::size_t>(folds) /
                                             std::max<std::size_t>(1, total)) == fold;
      auto& side = left_out ? parts.judge : parts.learn;
      side.insert(side.end(), touch.begin(), touch.end());
      before += touch.size();
    }
    if (parts.learn.size() >= kMinSamples) result.push_back(std::move(parts));
  }
  return result;
}

}  // namespace palpate::tactile
