// SPDX-License-Identifier: Apache-2.0
#include "tactile/normals/plane_fit.hpp"

#include <Eigen/Eigenvalues>
#include <cmath>

#include "palpate/core/option_check.hpp"
#include "tactile/normals/estimate_status.hpp"

namespace palpate::tactile {
namespace {

constexpr std::size_t kMinPoints = 4;
constexpr double kFlat = 1e-12;  // of the largest eigenvalue; two as small leave a line

Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen_of(const Eigen::Matrix3d& A) {
  Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver;
  solver.computeDirect(A);
  return solver;
}

Eigen::Vector3d against(const Eigen::Vector3d& f, const Eigen::Vector3d& n) {
  return n.dot(f) > 0 ? Eigen::Vector3d(-n) : n;
}

}  // namespace

PlaneFitEstimator::PlaneFitEstimator(const PlaneFitOptions& options)
    : options_(checked(options)), lifts_(options.forget_after) {}

void PlaneFitEstimator::start() {
  window_.clear();
  n_.reset();
  covariance_.reset();
}

void PlaneFitEstimator::fit(const Eigen::Vector3d& f) {
  const auto count = static_cast<double>(window_.size());
  Eigen::Vector3d center = Eigen::Vector3d::Zero();
  for (const FingerSample& sample : window_) center += sample.p / count;
  Eigen::Matrix3d scatter = Eigen::Matrix3d::Zero();
  for (const FingerSample& sample : window_) {
    const Eigen::Vector3d d = sample.p - center;
    scatter += d * d.transpose() / count;
  }
  const auto eigen = eigen_of(scatter);
  const Eigen::Vector3d l = eigen.eigenvalues();
  if (l[1] <= kFlat * l[2]) return;  // all on a line
  n_ = against(f, eigen.eigenvectors().col(0));
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  const double noise = std::max(l[0], 0.0);
  for (int i = 1; i < 3; ++i) {
    const double gap = std::max(l[i] - noise, kFlat * l[2]);
    const Eigen::Vector3d axis = eigen.eigenvectors().col(i);
    covariance += noise * l[i] / (gap * gap * (count - 3)) * axis * axis.transpose();
  }
  covariance_ = covariance;
}

NormalEstimate PlaneFitEstimator::update(const FingerSample& sample) {
  if (lifts_.begins(sample)) start();
  if (!sample.flags.usable()) return held(sample.time, n_, covariance_);
  window_.push_back(sample);
  while (sample.time - window_.front().time > options_.window) window_.pop_front();
  if (window_.size() >= kMinPoints) fit(sample.f);
  return tracked(sample.time, n_, covariance_);
}

EigenvectorEstimator::EigenvectorEstimator(const EigenvectorOptions& options)
    : options_(checked(options)), lifts_(options.forget_after), low_pass_(options.low_pass) {}

void EigenvectorEstimator::start() {
  low_pass_.clear();
  squares_.setZero();
  last_.reset();
  n_.reset();
}

void EigenvectorEstimator::learn(const FingerSample& sample, double dt) {
  const Eigen::Vector3d v = low_pass_.add((sample.p - last_->p) / dt);
  const double path = v.norm() * dt;
  if (!low_pass_.full() || path == 0) return;
  const Eigen::Vector3d u = v.normalized(), w = sample.f.normalized().cross(u);
  squares_ *= std::exp(-path / options_.distance);
  squares_ += path * (u * u.transpose() + options_.force_weight * w * w.transpose());
  const auto eigen = eigen_of(squares_);
  if (eigen.eigenvalues()[1] <= kFlat * eigen.eigenvalues()[2]) return;
  n_ = against(sample.f, eigen.eigenvectors().col(0));
}

NormalEstimate EigenvectorEstimator::update(const FingerSample& sample) {
  if (lifts_.begins(sample)) start();
  if (!sample.flags.usable()) return held(sample.time, n_, {});
  if (last_ && sample.time > last_->time) learn(sample, sample.time - last_->time);
  last_ = sample;
  return tracked(sample.time, n_, {});
}

}  // namespace palpate::tactile
