// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

namespace palpate::relocate {

/// The object's position as a tracker by touch estimates it (estimation::OnlineTracker, in short):
/// the place where it rested, until two fingertips touch it; then, every period, that of one period
/// ago. Once the palm has risen, what the hand touches is taken to move with it meanwhile.
class SparseObservation {
 public:
  /// @param period  in control steps; 0: the position is always the true one
  void reset(const Eigen::Vector3d& object, const Eigen::Vector3d& palm, int period);

  /// Called after every control step. @param tips  how many fingertips touch the object
  void update(const Eigen::Vector3d& object, const Eigen::Vector3d& palm, int tips);

  const Eigen::Vector3d& position() const { return observed_; }

 private:
  int period_ = 0, step_ = 0;
  double lowest_palm_ = 0;
  Eigen::Vector3d observed_ = Eigen::Vector3d::Zero(), coming_ = observed_, palm_ = observed_;
};

}  // namespace palpate::relocate
