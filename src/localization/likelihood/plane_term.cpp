// SPDX-License-Identifier: Apache-2.0
#include "localization/likelihood/plane_term.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace palpate::localization {
namespace {

constexpr double kMissShare = 0.05;  // m: something else, a part of the hand, met the plane
constexpr double kMissRange = 0.05;  // L, m

}  // namespace

PlaneTerm::PlaneTerm(const geometry::ObjectModel& model, const Evidence& evidence, double scale)
    : hull_(model.hull()) {
  for (const PlaneContact& plane : evidence.planes) {
    const double sigma = scale * plane.sigma;
    const double met = (1 - kMissShare) / (std::sqrt(2 * std::numbers::pi) * sigma);
    const double missed = kMissShare / kMissRange;
    log_peak_ += std::log(met + missed);
    planes_.push_back({plane.normal.cast<float>(), static_cast<float>(plane.height),
                       static_cast<float>(1 / sigma), static_cast<float>(std::log(met / missed))});
  }
}

PlaneTerm::Lowest PlaneTerm::lowest(const SearchPose& pose, const Plane& plane) const {
  const Eigen::Vector3f down = -(pose.R.transpose() * plane.normal);  // in the object's frame
  const Eigen::Vector3f* corner = nullptr;
  float most = -kNoBound;
  for (const Eigen::Vector3f& candidate : hull_) {
    const float depth = down.dot(candidate);
    if (depth <= most) continue;
    most = depth;
    corner = &candidate;
  }
  return {pose.R * *corner, plane.normal.dot(pose.t) - most - plane.height};
}

float PlaneTerm::energy(const SearchPose& pose, float) const {
  float sum = 0;
  for (const Plane& plane : planes_) {
    const float r = lowest(pose, plane).above * plane.precision;
    const float met = 0.5F * r * r;
    sum += std::min(met, plane.missed) - std::log1p(std::exp(-std::abs(met - plane.missed))) +
           std::log1p(std::exp(-plane.missed));
  }
  return sum;
}

void PlaneTerm::linearize(const SearchPose& pose, NormalEquations& equations) const {
  for (const Plane& plane : planes_) {
    const Lowest touching = lowest(pose, plane);
    const float r = touching.above * plane.precision;
    Eigen::Matrix<double, 1, 6> J;
    J << touching.corner.cross(plane.normal).transpose().cast<double>(),
        plane.normal.transpose().cast<double>();
    J *= static_cast<double>(plane.precision);
    const double share = 1 / (1 + std::exp(static_cast<double>(0.5F * r * r - plane.missed)));
    equations.add(J, Eigen::Matrix<double, 1, 1>(static_cast<double>(r)), share);
  }
}

}  // namespace palpate::localization
