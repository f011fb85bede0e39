// SPDX-License-Identifier: Apache-2.0
#include "tactile/normals/s2_smoother.hpp"

#include <cmath>
#include <utility>

#include "palpate/core/se3.hpp"
#include "tactile/normals/estimate_status.hpp"

namespace palpate::tactile {
namespace {

constexpr double kLongestBridge = 0.05;  // s without a sample, in which the finger may have left

struct Smoothed {
  Eigen::Matrix3d R;  // tangents and normal
  Eigen::Matrix2d P;  // of the tilt towards these tangents
};

/// How far n is tilted towards the tangents of R, as an angle.
Eigen::Vector2d tilt_of(const Eigen::Vector3d& n, const Eigen::Matrix3d& R) {
  const Eigen::Vector3d in_frame = R.transpose() * n;
  const Eigen::Vector2d aside = in_frame.head<2>();
  const double sine = aside.norm();
  return sine < 1e-12 ? aside : Eigen::Vector2d(aside * (std::atan2(sine, in_frame.z()) / sine));
}

/// Smoothed normal of a tick from that of the next.
Smoothed step_back(const Eigen::Matrix3d& R, const Eigen::Matrix2d& P, const S2Filter::Step& step,
                   const Smoothed& next) {
  const Eigen::Vector2d ahead = tilt_of(next.R.col(2), step.R_predicted);
  Eigen::Vector2d mean = Eigen::Vector2d::Zero();
  std::array<Eigen::Vector2d, S2Filter::kHypotheses> tilt;
  Eigen::Matrix2d smoothed = Eigen::Matrix2d::Zero();
  for (std::size_t k = 0; k < tilt.size(); ++k) {
    const Eigen::Matrix2d gain = P * step.covariance[k].inverse();
    tilt[k] = gain * ahead;
    mean += step.weight[k] * tilt[k];
    smoothed += step.weight[k] * (P + gain * (next.P - step.covariance[k]) * gain.transpose());
  }
  for (std::size_t k = 0; k < tilt.size(); ++k) {
    smoothed += step.weight[k] * (tilt[k] - mean) * (tilt[k] - mean).transpose();
  }
  return {R * exp_so3({-mean.y(), mean.x(), 0}), smoothed};
}

}  // namespace

S2Smoother::S2Smoother(const S2Options& options) : options_(options), filter_(options) {}

/// Of the oldest tick, from all later ones.
NormalEstimate S2Smoother::smoothed_first() {
  Smoothed smoothed{ticks_.back().R, ticks_.back().P};
  for (std::size_t i = ticks_.size() - 1; i-- > 0;) {
    const bool left = ticks_[i + 1].time - ticks_[i].time > kLongestBridge;
    smoothed = left ? Smoothed{ticks_[i].R, ticks_[i].P}
                    : step_back(ticks_[i].R, ticks_[i].P, ticks_[i + 1].step, smoothed);
  }
  const Eigen::Matrix<double, 3, 2> B = smoothed.R.leftCols<2>();
  const double still = 1 - ticks_.front().step.stillness;
  const auto status = ticks_.front().time == reported_ ? NormalStatus::held : NormalStatus::tracked;
  reported_ = ticks_.front().time;
  return estimate_of(reported_, status, Eigen::Vector3d(smoothed.R.col(2)),
                     still * B * smoothed.P * B.transpose());
}

/// The contact has ended: what was learnt of its last ticks is all that will be.
void S2Smoother::flush() {
  for (; !ticks_.empty(); ticks_.pop_front()) {
    const NormalEstimate estimate = smoothed_first();
    if (estimate.status == NormalStatus::tracked) late_.push_back(estimate);
  }
}

NormalEstimate S2Smoother::update(const FingerSample& sample) {
  const NormalEstimate now = filter_.update(sample);
  if (now.status != NormalStatus::tracked) return now;
  if (filter_.last_step().anew) flush();
  ticks_.push_back({sample.time, filter_.frame(), filter_.tilt_covariance(), filter_.last_step()});
  while (ticks_.size() > 1 && ticks_[1].time <= sample.time - options_.lag + 1e-9)
    ticks_.pop_front();
  if (ticks_.front().time > sample.time - options_.lag + 1e-9) {
    NormalEstimate early;
    early.time = sample.time - options_.lag;
    return early;
  }
  return smoothed_first();
}

std::vector<NormalEstimate> S2Smoother::take_late(bool ended) {
  if (ended) flush();
  return std::exchange(late_, {});
}

}  // namespace palpate::tactile
