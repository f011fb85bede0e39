// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>

namespace palpate::skills {

/// Notices that a fingertip touches, by its forces added up: one reading of the force asked for is
/// enough, and so are several of a smaller one, which would push a light object along.
class TouchDetector {
 public:
  /// @param force  N, of a single reading that counts as touch
  explicit TouchDetector(double force) : force_(force) {}

  /// @param normal_force  N, of this tick
  /// @return whether it touches
  bool update(double normal_force) {
    sum_ = std::clamp(sum_ + normal_force - kForgotten * force_, 0.0, force_);
    return sum_ > (1 - kForgotten) * force_;
  }

 private:
  static constexpr double kForgotten = 0.2;  // of the force, each tick

  double force_, sum_ = 0;
};

}  // namespace palpate::skills
