// SPDX-License-Identifier: Apache-2.0
#include "tasks/relocate/sparse_observation.hpp"

#include <algorithm>

namespace palpate::relocate {
namespace {

constexpr double kLifts = 0.005;  // m that the palm has risen, as OnlineTrackerOptions::lifts
constexpr int kMinTips = 2;       // that must touch, as OnlineTrackerOptions::fingers

}  // namespace

void SparseObservation::reset(const Eigen::Vector3d& object, const Eigen::Vector3d& palm,
                              int period) {
  period_ = period;
  step_ = 0;
  lowest_palm_ = palm.z();
  palm_ = palm;
  observed_ = coming_ = object;
}

void SparseObservation::update(const Eigen::Vector3d& object, const Eigen::Vector3d& palm,
                               int tips) {
  if (period_ == 0) {
    observed_ = object;
    return;
  }
  lowest_palm_ = std::min(lowest_palm_, palm.z());
  if (tips > 0 && palm.z() > lowest_palm_ + kLifts) {
    observed_ += palm - palm_;
    coming_ += palm - palm_;
  }
  palm_ = palm;
  if (++step_ % period_ != 0) return;
  observed_ = coming_;
  if (tips >= kMinTips) coming_ = object;
}

}  // namespace palpate::relocate
