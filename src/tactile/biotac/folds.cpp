// SPDX-License-Identifier: Apache-2.0
#include "tactile/biotac/folds.hpp"

#include <algorithm>

namespace palpate::tactile {
namespace {

constexpr std::size_t kMinSamples = 10;

struct Touch {
  std::vector<BiotacSample> samples, causal;
};

std::vector<Touch> touches_of(const std::vector<BiotacLog>& logs) {
  std::vector<Touch> touches;
  for (const BiotacLog& log : logs) {
    const BiotacSignals signals = biotac_signals(log);
    const BiotacSignals causal = biotac_signals(log, BiotacRest::causal);
    const auto sample = [&](const BiotacSignals& of, std::size_t i) {
      return BiotacSample{of.changes[i], *log.normals[i], of.rests[i]};
    };
    bool touching = false;
    for (std::size_t i = 0; i < log.time.size(); ++i) {
      const bool usable = biotac_usable(signals.flags[i]) && log.normals[i].has_value();
      if (usable && !touching) touches.emplace_back();
      touching = usable;
      if (!usable) continue;
      touches.back().samples.push_back(sample(signals, i));
      if (biotac_usable(causal.flags[i])) touches.back().causal.push_back(sample(causal, i));
    }
  }
  return touches;
}

void append(const std::vector<BiotacSample>& more, std::vector<BiotacSample>& all) {
  all.insert(all.end(), more.begin(), more.end());
}

}  // namespace

std::vector<BiotacFold> folds_of_touches(const std::vector<BiotacLog>& logs, int folds) {
  const auto touches = touches_of(logs);
  std::size_t total = 0;
  for (const auto& touch : touches) total += touch.samples.size();
  std::vector<BiotacFold> result;
  for (int fold = 0; fold < folds; ++fold) {
    BiotacFold parts;
    std::size_t before = 0;
    for (const auto& touch : touches) {
      const std::size_t middle = before + touch.samples.size() / 2;
      const bool left_out = static_cast<int>(middle * static_cast<std::size_t>(folds) /
                                             std::max<std::size_t>(1, total)) == fold;
      append(touch.samples, left_out ? parts.test : parts.training);
      if (left_out) append(touch.causal, parts.test_causal);
      before += touch.samples.size();
    }
    if (parts.training.size() >= kMinSamples) result.push_back(std::move(parts));
  }
  return result;
}

}  // namespace palpate::tactile
