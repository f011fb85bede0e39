// SPDX-License-Identifier: Apache-2.0
#include "localization/likelihood/pose_mixture.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <numbers>

namespace palpate::localization {
namespace {

using std::numbers::pi;
using Vector6f = Eigen::Matrix<float, 6, 1>;

constexpr double kReach = 8;  // sigma; beyond it a component counts for nothing

double widest_sigma(const Eigen::Matrix3d& covariance) {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> spectrum(covariance, Eigen::EigenvaluesOnly);
  return std::sqrt(spectrum.eigenvalues()[2]);
}

/// Rotation vector of a quaternion with w >= 0.
Eigen::Vector3f rotation_vector(const Eigen::Quaternionf& q) {
  const float sine = q.vec().norm();
  if (sine < 1e-6F) return 2 * q.vec();
  return 2 * std::atan2(sine, q.w()) / sine * q.vec();
}

}  // namespace

double total_weight(const PosePrior& prior) {
  double sum = 0;
  for (const auto& component : prior.components) sum += component.weight;
  return sum;
}

PoseMixture::PoseMixture(const PosePrior& prior) {
  const double total = total_weight(prior);
  std::vector<double> log_peaks;
  for (const auto& given : prior.components) {
    if (given.weight <= 0) continue;
    const Matrix6d L = given.covariance.llt().matrixL();
    const double angle = kReach * widest_sigma(given.covariance.topLeftCorner<3, 3>());
    const double distance = kReach * widest_sigma(given.covariance.bottomRightCorner<3, 3>());
    Component component;
    component.q = Eigen::Quaterniond(given.T_frame_object.linear()).normalized().cast<float>();
    component.t = given.T_frame_object.translation().cast<float>();
    component.min_cosine = static_cast<float>(std::cos(std::min(angle, pi) / 2) - 1e-6);
    component.max_distance = static_cast<float>(distance * distance);
    component.whitening = L.inverse().cast<float>();
    component.share = given.weight / total;
    component.factor = L;
    components_.push_back(component);
    log_peaks.push_back(std::log(component.share) - 3 * std::log(2 * pi) -
                        L.diagonal().array().log().sum());
  }
  log_peak_ = *std::max_element(log_peaks.begin(), log_peaks.end());
  for (std::size_t i = 0; i < components_.size(); ++i) {
    components_[i].peak = static_cast<float>(std::exp(log_peaks[i] - log_peak_));
    highest_ += std::exp(log_peaks[i] - log_peak_);
  }
}

std::optional<Vector6f> PoseMixture::whitened(const Component& component,
                                              const Eigen::Quaternionf& q,
                                              const Eigen::Vector3f& t) {
  const float cosine = q.dot(component.q);
  if (std::abs(cosine) < component.min_cosine) return std::nullopt;
  const Eigen::Vector3f away = t - component.t;
  if (away.squaredNorm() > component.max_distance) return std::nullopt;
  Eigen::Quaternionf turn = q * component.q.conjugate();
  if (cosine < 0) turn.coeffs() *= -1;
  Vector6f x;
  x.head<3>() = rotation_vector(turn);
  x.tail<3>() = away;
  return component.whitening.triangularView<Eigen::Lower>() * x;
}

double PoseMixture::relative_density(const SearchPose& pose) const {
  const Eigen::Quaternionf q(pose.R);
  float sum = 0;
  for (const Component& component : components_) {
    const auto white = whitened(component, q, pose.t);
    if (white) sum += component.peak * std::exp(-0.5F * white->squaredNorm());
  }
  return static_cast<double>(sum);
}

void PoseMixture::linearize(const SearchPose& pose, double floor,
                            NormalEquations& equations) const {
  const Eigen::Quaternionf q(pose.R);
  const double density = relative_density(pose) + floor;
  for (const Component& component : components_) {
    const auto white = whitened(component, q, pose.t);
    if (!white) continue;
    const double here =
        static_cast<double>(component.peak * std::exp(-0.5F * white->squaredNorm()));
    equations.add(component.whitening.cast<double>(), white->cast<double>(), here / density);
  }
}

SearchPose PoseMixture::draw(RandomStream& random) const {
  double left = random.uniform();
  std::size_t i = 0;
  while (i + 1 < components_.size() && left >= components_[i].share) left -= components_[i++].share;
  const Component& component = components_[i];
  Vector6d x;
  x.head<3>() = random.normal3();
  x.tail<3>() = random.normal3();
  x = component.factor * x;
  return {turn_by(x.head<3>().cast<float>()) * component.q.toRotationMatrix(),
          component.t + x.tail<3>().cast<float>()};
}

}  // namespace palpate::localization
