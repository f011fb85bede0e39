// SPDX-License-Identifier: Apache-2.0
#include <cmath>

#include "palpate/tactile/biotac/normal.hpp"
#include "tactile/biotac/faults.hpp"

namespace palpate::tactile {
namespace {

/// A frame of a touch: what it measures, then what its neighbours measure with it.
struct TrackedNormal {
  std::size_t frame;
  double time;  // s
  Eigen::Vector3d n;
  double measured = 0;  // variance of this frame's own error, rad^2
  double variance = 0;  // of what is tracked, as if the frames' errors were independent, rad^2
  double stated = 0;    // the same with the errors in common, rad^2
};

/// From a towards b by a share of the way; a itself where that has no direction.
Eigen::Vector3d between(const Eigen::Vector3d& a, const Eigen::Vector3d& b, double share) {
  const Eigen::Vector3d mixed = a + share * (b - a);
  return mixed.norm() > 1e-9 ? mixed.normalized() : a;
}

/// Kalman filter of a random walk on the sphere, whose rate is given in rad^2/s.
void filter(std::vector<TrackedNormal>& touch, double rate) {
  for (std::size_t i = 0; i < touch.size(); ++i) {
    TrackedNormal& now = touch[i];
    if (i == 0) {
      now.variance = now.stated = now.measured;
      continue;
    }
    const TrackedNormal& before = touch[i - 1];
    const double walked = rate * (now.time - before.time);
    const double predicted = before.variance + walked;
    const double gain = predicted / (predicted + now.measured);
    now.n = between(before.n, now.n, gain);
    now.variance = (1 - gain) * predicted;
    now.stated = (1 - gain) * (before.stated + walked) + gain * now.measured;
  }
}

/// Backward pass over what was filtered (Rauch, Tung & Striebel 1965).
void smooth(std::vector<TrackedNormal>& touch, double rate) {
  for (std::size_t i = touch.size() - 1; i-- > 0;) {
    TrackedNormal& now = touch[i];
    const TrackedNormal& after = touch[i + 1];
    const double walked = rate * (after.time - now.time);
    const double gain = now.variance / (now.variance + walked);
    now.n = between(now.n, after.n, gain);
    now.stated = (1 - gain) * now.stated + gain * after.stated;
  }
}

/// Whether a frame cannot belong to the touch of the frames before it.
bool breaks_touch(unsigned flags) {
  return (flags & (bit(BiotacFlag::no_contact) | bit(BiotacFlag::late) |
                   bit(BiotacFlag::out_of_order) | bit(BiotacFlag::no_rest))) != 0;
}

}  // namespace

std::vector<std::optional<BiotacNormal>> BiotacNormalModel::track(const BiotacLog& log,
                                                                  const BiotacSignals& signals,
                                                                  BiotacRest tracking) const {
  const auto predictions = predict(signals.changes, signals.rests);
  const double rate = turning_ * turning_;
  std::vector<std::optional<BiotacNormal>> result(log.time.size());
  std::vector<TrackedNormal> touch;
  const auto finish = [&] {
    filter(touch, rate);
    if (tracking == BiotacRest::whole_log && !touch.empty()) smooth(touch, rate);
    for (const TrackedNormal& tracked : touch) {
      result[tracked.frame] = {.n = tracked.n,
                               .sigma = std::sqrt(tracked.stated + session_ * session_),
                               .novelty = predictions[tracked.frame]->novelty};
    }
    touch.clear();
  };
  for (std::size_t i = 0; i < log.time.size(); ++i) {
    if (breaks_touch(signals.flags[i])) finish();
    if (!biotac_usable(signals.flags[i]) || !predictions[i]) continue;
    touch.push_back(
        {.frame = i,
         .time = log.time[i],
         .n = predictions[i]->n,
         .measured = errors(tracking).variance(predictions[i]->variance, signals.changes[i][0])});
  }
  finish();
  return result;
}

}  // namespace palpate::tactile
