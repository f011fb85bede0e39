// SPDX-License-Identifier: Apache-2.0
#include "localization/likelihood/balance_term.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "palpate/core/se3.hpp"

namespace palpate::localization {
namespace {

constexpr float kOtherVariance = 100;                       // D: variance where it does
const float kOtherPeak = -1.5F * std::log(kOtherVariance);  // ln of D^(-3/2)
constexpr double kMinMoment = 1e-5;                         // N m, sigma that is always there

Eigen::Vector3d middle_of(const std::vector<ForceBalance::Push>& pushes) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const auto& push : pushes) sum += push.p;
  return sum / static_cast<double>(pushes.size());
}

/// Covariance of a x b where b errs by sigma per axis.
Eigen::Matrix3d cross_covariance(const Eigen::Vector3d& a, double sigma) {
  return sigma * sigma * (a.squaredNorm() * Eigen::Matrix3d::Identity() - a * a.transpose());
}

Eigen::Matrix3d moment_covariance(const ForceBalance& balance, const Eigen::Vector3d& middle) {
  Eigen::Matrix3d sum = kMinMoment * kMinMoment * Eigen::Matrix3d::Identity();
  for (const auto& push : balance.pushes) {
    const double twist = balance.torsional_friction_radius * push.f.norm();
    sum += cross_covariance(push.f, balance.point_sigma) +
           cross_covariance(push.p - middle, balance.force_sigma) +
           twist * twist * push.n * push.n.transpose();
  }
  return sum;
}

}  // namespace

BalanceTerm::BalanceTerm(const geometry::ObjectModel& model, const ForceBalance& balance,
                         double scale)
    : center_(model.object().mass_properties.centroid.cast<float>()),
      weight_(balance.weight.cast<float>()),
      other_support_prior_(static_cast<float>(balance.other_support_prior)) {
  const Eigen::Vector3d middle = middle_of(balance.pushes);
  Eigen::Vector3d moment = Eigen::Vector3d::Zero();
  for (const auto& push : balance.pushes) moment += (push.p - middle).cross(push.f);
  const Eigen::Matrix3d covariance = scale * scale * moment_covariance(balance, middle);
  const Eigen::Matrix3d lower = covariance.llt().matrixL();
  middle_ = middle.cast<float>();
  moment_ = moment.cast<float>();
  whitening_ = lower.inverse().cast<float>();
}

BalanceTerm::Exponents BalanceTerm::exponents(float q) const {
  return {std::log1p(-other_support_prior_) - q,
          std::log(other_support_prior_) + kOtherPeak - q / kOtherVariance};
}

Eigen::Vector3f BalanceTerm::whitened_moment(const SearchPose& pose) const {
  const Eigen::Vector3f arm = pose.R * center_ + pose.t - middle_;
  return whitening_ * (moment_ + arm.cross(weight_));
}

float BalanceTerm::energy(const SearchPose& pose, float) const {
  const auto [held, other] = exponents(0.5F * whitened_moment(pose).squaredNorm());
  return -std::max(held, other) - std::log1p(std::exp(-std::abs(held - other)));
}

void BalanceTerm::linearize(const SearchPose& pose, NormalEquations& equations) const {
  const Eigen::Vector3f r = whitened_moment(pose);
  const Eigen::Vector3d turned = (pose.R * center_).cast<double>();
  const Eigen::Matrix3d by_center =
      -whitening_.cast<double>() * skew(weight_.cast<double>());  // of r by the centre of mass
  Eigen::Matrix<double, 3, 6> J;
  J.leftCols<3>() = -by_center * skew(turned);
  J.rightCols<3>() = by_center;
  const auto [held, other] = exponents(0.5F * r.squaredNorm());
  const double trust = 1 / (1 + std::exp(static_cast<double>(other - held)));
  equations.add(J, r.cast<double>(), trust + (1 - trust) / static_cast<double>(kOtherVariance));
}

}  // namespace palpate::localization
