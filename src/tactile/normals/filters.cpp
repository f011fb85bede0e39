// SPDX-License-Identifier: Apache-2.0
#include "tactile/normals/filters.hpp"

#include <fmt/format.h>

#include <cmath>

#include "palpate/core/error.hpp"

namespace palpate::tactile {

RollingMean::RollingMean(int window) : window_(static_cast<std::size_t>(window)) {
  if (window < 1) throw BadInput(fmt::format("a rolling mean needs a window, not {}", window));
  values_.reserve(window_);
}

Eigen::Vector3d RollingMean::add(const Eigen::Vector3d& value) {
  if (full()) {
    values_[next_] = value;
  } else {
    values_.push_back(value);
  }
  next_ = (next_ + 1) % window_;
  // Summed again each time: a running sum would keep the rounding of values long gone.
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const Eigen::Vector3d& v : values_) sum += v;
  return sum / static_cast<double>(values_.size());
}

void RollingMean::clear() {
  values_.clear();
  next_ = 0;
}

ExponentialDecay::ExponentialDecay(double time_constant) : time_constant_(time_constant) {
  if (!(time_constant > 0)) {
    throw BadInput(fmt::format("a time constant must be positive, not {} s", time_constant));
  }
}

Eigen::Vector3d ExponentialDecay::add(const Eigen::Vector3d& value, double dt) {
  if (!started_) state_ = value;
  started_ = true;
  state_ += -std::expm1(-dt / time_constant_) * (value - state_);
  return state_;
}

}  // namespace palpate::tactile
