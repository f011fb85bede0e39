// SPDX-License-Identifier: Apache-2.0
#include "tactile/biotac/rest_tracker.hpp"

#include <algorithm>

#include "palpate/core/statistics.hpp"

namespace palpate::tactile {
namespace {

constexpr std::size_t kMedianFrames = 5;
constexpr double kRiseRate = 2;           // counts/s, of the envelope
constexpr double kQuietPressure = 6;      // counts
constexpr std::size_t kQuietFrames = 10;  // until rest is known
constexpr std::size_t kDoubtfulFrames =
    3;                          // the newest quiet ones, in which a touch may have begun
constexpr double kShare = 0.3;  // of the way to a quiet frame

}  // namespace

BiotacChannels BiotacRestTracker::median_of_last() const {
  BiotacChannels result;
  std::vector<double> values;
  for (Eigen::Index c = 0; c < kBiotacChannels; ++c) {
    values.clear();
    for (const BiotacChannels& channels : last_) values.push_back(channels[c]);
    result[c] = median(values);
  }
  return result;
}

void BiotacRestTracker::follow(const BiotacChannels& quiet) {
  quiet_.push_back(quiet);
  if (!rest_) {
    if (quiet_.size() < kQuietFrames) return;
    rest_ = quiet_.front();
  }
  for (; quiet_.size() > kDoubtfulFrames; quiet_.pop_front()) {
    *rest_ += kShare * (quiet_.front() - *rest_);
  }
}

const std::optional<BiotacChannels>& BiotacRestTracker::step(double time,
                                                             const BiotacChannels& channels) {
  const bool first = last_.empty();
  last_.push_back(channels);
  if (last_.size() > kMedianFrames) last_.pop_front();
  const BiotacChannels now = median_of_last();
  const double rise = first ? 0 : kRiseRate * std::max(0.0, time - time_);
  envelope_ = first ? now[0] : std::min(envelope_ + rise, now[0]);
  time_ = time;
  if (rest_ && now[0] < (*rest_)[0] - kQuietPressure) rest_.reset();
  if (now[0] < envelope_ + kQuietPressure) {
    follow(now);
  } else {
    quiet_.clear();
  }
  return rest_;
}

}  // namespace palpate::tactile
