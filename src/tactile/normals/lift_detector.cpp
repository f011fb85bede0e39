// SPDX-License-Identifier: Apache-2.0
#include "tactile/normals/lift_detector.hpp"

#include <algorithm>
#include <vector>

namespace palpate::tactile {
namespace {

constexpr std::size_t kStepsKept = 9;    // whose median is usual
constexpr double kLongestBounce = 0.05;  // s, in which a finger cannot reach another place
constexpr double kLongestLoss = 2.5;     // periods, of samples that were lost
constexpr double kNextSample = 1.5;      // periods
constexpr double kLongestStep = 4;       // times the usual one
constexpr double kStepMargin = 0.002;    // m

}  // namespace

double LiftDetector::usual(double Step::*value) const {
  std::vector<double> values;
  for (const Step& step : steps_) values.push_back(step.*value);
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

bool LiftDetector::lifted(const Step& step) const {
  if (step.time < 0 || step.time > forget_after_) return true;  // below 0: by another clock
  if (away_ && step.time > kLongestBounce) return true;
  if (steps_.empty()) return false;
  const double periods = step.time / usual(&Step::time);
  if (step.time > kLongestBounce && periods > kLongestLoss) return true;
  if (!away_ && periods < kNextSample) return false;  // if far off, an outlier
  const double usual_step = usual(&Step::length) * std::max(periods, 1.0);
  return step.length > kLongestStep * usual_step + kStepMargin;
}

bool LiftDetector::begins(const FingerSample& sample) {
  if (!sample.flags.usable()) {
    away_ =
        away_ || sample.flags.has(SampleFlag::no_contact) || sample.flags.has(SampleFlag::no_force);
    return false;
  }
  bool result = true;
  if (last_) {
    const Step step{sample.time - last_->time, (sample.p - last_->p).norm()};
    result = lifted(step);
    if (step.time > 0) steps_.push_back(step);
    if (steps_.size() > kStepsKept) steps_.pop_front();
  }
  last_ = sample;
  away_ = false;
  return result;
}

}  // namespace palpate::tactile
