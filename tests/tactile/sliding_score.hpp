// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/LU>
#include <map>
#include <numbers>

#include "normal_clusters.hpp"
#include "palpate/tactile/biotac/normal.hpp"
#include "palpate/tactile/normals/normal_estimator.hpp"
#include "tactile/sliding.hpp"

namespace palpate::tactile {

/// How far estimates are from the truth.
struct SlidingScore {
  std::vector<double> error_deg;
  std::vector<double> nees;  // normalised error squared; 2 on average of an honest covariance
  std::vector<NormalAt> estimates;
};

/// d' C^+ d of the angular error d between n and the truth.
inline double normalised_error_squared(const Eigen::Vector3d& n, const Eigen::Vector3d& truth,
                                       const Eigen::Matrix3d& covariance) {
  const Eigen::Matrix<double, 3, 2> B = frame_with_z(n).leftCols<2>();
  const Eigen::Vector2d aside = B.transpose() * truth;
  if (aside.norm() == 0) return 0;
  const Eigen::Vector2d d =
      aside.normalized() * angle_between_deg(n, truth) * std::numbers::pi / 180;
  const Eigen::Matrix2d C = B.transpose() * covariance * B;
  return d.dot(C.inverse() * d);
}

/// Adds a slide's estimates of the time from `settled` (s) on. An estimator that has no estimate by
/// then is wrong by 90 degrees.
inline void add_score(NormalEstimator& estimator, const std::vector<FingerSample>& samples,
                      const SlidingPath& path, double period, SlidingScore& score,
                      double settled = 1.0) {
  std::map<long, Eigen::Vector3d> points;  // by tick
  for (const FingerSample& sample : samples) {
    points[std::lround(sample.time / period)] = sample.p;
    const NormalEstimate estimate = estimator.update(sample);
    if (estimate.time < settled - 1e-9) continue;
    if (estimate.status == NormalStatus::none) {
      score.error_deg.push_back(90);
      continue;
    }
    const long tick = std::lround(estimate.time / period);
    const auto& truth = path.n.at(static_cast<std::size_t>(tick));
    score.error_deg.push_back(angle_between_deg(estimate.n, truth));
    score.estimates.push_back({points.at(tick), estimate.n});
    if (estimate.covariance) {
      score.nees.push_back(normalised_error_squared(estimate.n, truth, *estimate.covariance));
    }
  }
}

}  // namespace palpate::tactile
