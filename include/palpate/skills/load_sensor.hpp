// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include "palpate/hand/hand.hpp"

namespace palpate::skills {

class Executor;

/// What the mount's load reads where nothing but the hand hangs on it, N.
struct LoadError {
  Eigen::Vector3d bias = Eigen::Vector3d::Zero();  ///< in the mount's frame
  double weight = 0;                               ///< upwards
};

/// The sensor of the mount's load, and what is known of its error.
class LoadSensor {
 public:
  const LoadError& error() const { return error_; }
  /// From now on loads are read without this.
  void set_error(const LoadError& error) { error_ = error; }

  /// Takes the error off the load of a reading.
  void correct(hand::HandReading& reading);
  /// N, of the last reading, with its error
  const Eigen::Vector3d& sensed() const { return sensed_; }

 private:
  LoadError error_;
  Eigen::Vector3d sensed_ = Eigen::Vector3d::Zero();
};

/// Waits until the load on the mount stands still, for a second at most. @return it, N
Eigen::Vector3d steady_load(Executor& robot);

/// The hand stands free: its steady load, beyond what is known of the error, is a drift of it.
void tare(Executor& robot);

}  // namespace palpate::skills
