// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

namespace palpate::tactile {

/// Measures the white noise on a smooth signal by the second differences of its samples, whose
/// variance is six times that of the noise. Jumps of the signal are clipped.
class NoiseMeter {
 public:
  /// @param axes      that the noise has: 3, or 2 for that of unit vectors
  /// @param sigma     standard deviation per axis believed at first
  /// @param least     smallest that is ever reported
  /// @param memory    samples
  NoiseMeter(int axes, double sigma, double least, double memory);

  void add(const Eigen::Vector3d& value);
  /// Forgets the last values, not what was learnt: the next one does not follow them.
  void interrupt() { count_ = 0; }
  [[nodiscard]] double sigma() const;

 private:
  double axes_, variance_, least_, memory_, weight_;
  int count_ = 0;
  Eigen::Vector3d before_, last_;
};

}  // namespace palpate::tactile
