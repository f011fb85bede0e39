// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "palpate/tactile/normals/normal_estimator.hpp"

namespace palpate::tactile {

inline NormalEstimate estimate_of(double time, NormalStatus status,
                                  const std::optional<Eigen::Vector3d>& n,
                                  const std::optional<Eigen::Matrix3d>& covariance) {
  NormalEstimate estimate;
  estimate.time = time;
  if (!n) return estimate;
  estimate.status = status;
  estimate.n = *n;
  estimate.covariance = covariance;
  return estimate;
}

/// The estimate after a sample of no use; none without a normal.
inline NormalEstimate held(double time, const std::optional<Eigen::Vector3d>& n,
                           const std::optional<Eigen::Matrix3d>& covariance) {
  return estimate_of(time, NormalStatus::held, n, covariance);
}

/// The estimate after a usable sample; none without a normal.
inline NormalEstimate tracked(double time, const std::optional<Eigen::Vector3d>& n,
                              const std::optional<Eigen::Matrix3d>& covariance) {
  return estimate_of(time, NormalStatus::tracked, n, covariance);
}

}  // namespace palpate::tactile
