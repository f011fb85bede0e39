// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <vector>

namespace palpate::tactile {

/// Rolling low-pass filter: the mean of the last `window` values (thesis 5.2.1 uses 100).
class RollingMean {
 public:
  /// @throws BadInput unless window is at least 1
  explicit RollingMean(int window);

  /// Adds a value and returns the mean of those seen, at most `window`.
  Eigen::Vector3d add(const Eigen::Vector3d& value);
  void clear();
  [[nodiscard]] bool full() const { return values_.size() == window_; }

 private:
  std::size_t window_, next_ = 0;
  std::vector<Eigen::Vector3d> values_;
};

/// Exponential decay filter (thesis 5.2.2): y += (1 - exp(-dt / time_constant)) (x - y), started at
/// the first value; exact for a held input at any sampling.
class ExponentialDecay {
 public:
  /// @param time_constant  s; after it a step has come through by 1 - 1/e
  /// @throws BadInput unless it is positive
  explicit ExponentialDecay(double time_constant);

  /// @param dt  s since the last value
  Eigen::Vector3d add(const Eigen::Vector3d& value, double dt);
  void clear() { started_ = false; }

 private:
  double time_constant_;
  bool started_ = false;
  Eigen::Vector3d state_ = Eigen::Vector3d::Zero();
};

}  // namespace palpate::tactile
