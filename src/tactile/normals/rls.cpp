// SPDX-License-Identifier: Apache-2.0
#include "tactile/normals/rls.hpp"

#include <Eigen/Eigenvalues>
#include <cmath>

#include "palpate/core/option_check.hpp"
#include "palpate/core/se3.hpp"
#include "tactile/normals/estimate_status.hpp"

namespace palpate::tactile {

RlsEstimator::RlsEstimator(const RlsOptions& options)
    : options_(checked(options)), lifts_(options.forget_after), low_pass_(options.low_pass) {}

void RlsEstimator::forget() {
  low_pass_.clear();
  last_.reset();
  last_v_.reset();
  n_.reset();
}

/// n0 = v1 x v0 (eq. 5.4), or the direction against the force.
void RlsEstimator::start(const FingerSample& sample, const Eigen::Vector3d& v) {
  L1_.setZero();
  L2_.setZero();
  if (!options_.literal) {
    n_ = -sample.f.normalized();
  } else if (last_v_) {
    const Eigen::Vector3d cross = v.cross(*last_v_);
    if (cross.norm() > 1e-9 * v.norm() * last_v_->norm()) n_ = cross.normalized();
  }
  last_v_ = v;
}

/// Eqs 5.5-5.7.
void RlsEstimator::learn(const Eigen::Vector3d& f, const Eigen::Vector3d& v, double dt) {
  const Eigen::Vector3d w = f.cross(v);
  const double keep = options_.literal ? 1 - options_.decay * dt : std::exp(-options_.decay * dt);
  const double held = options_.literal || options_.decay == 0
                          ? dt
                          : -std::expm1(-options_.decay * dt) / options_.decay;
  const double take = held * options_.gain;
  L1_ = keep * L1_ + take / (1 + v.squaredNorm()) * v * v.transpose();
  L2_ = keep * L2_ + take / (1 + w.squaredNorm()) * w * w.transpose();
}

/// Eqs 5.8-5.10. As printed they are an Euler step, which diverges where the gain times dt exceeds
/// 2; otherwise the gradient's flow over dt with L1 and L2 held, which is exact for any dt: n turns
/// as exp(-dt (gamma1 L1 + gamma2 L2)) n does.
void RlsEstimator::turn(const Eigen::Vector3d& f, double dt) {
  const Eigen::Matrix3d M = options_.gamma1 * L1_ + options_.gamma2 * L2_;
  if (options_.literal) {
    n_ = (exp_so3(dt / 2 * n_->cross(-M * *n_)) * *n_).normalized();
    return;
  }
  Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen;
  eigen.computeDirect(M);
  const Eigen::Vector3d rates = (eigen.eigenvalues().array() - eigen.eigenvalues()[0]).max(0.0);
  const Eigen::Vector3d shrunk = (-dt * rates).array().exp();
  const Eigen::Matrix3d& axes = eigen.eigenvectors();
  const Eigen::Vector3d turned = axes * shrunk.cwiseProduct(axes.transpose() * *n_);
  if (turned.norm() > 0) n_ = turned.normalized();
  if (n_->dot(f) > 0) *n_ *= -1;
}

NormalEstimate RlsEstimator::update(const FingerSample& sample) {
  if (lifts_.begins(sample)) forget();
  if (!sample.flags.usable()) return held(sample.time, n_, {});
  if (last_ && sample.time > last_->time) {
    const double dt = sample.time - last_->time;
    const Eigen::Vector3d v = low_pass_.add((sample.p - last_->p) / dt);
    const Eigen::Vector3d f = options_.literal ? sample.f : sample.f.normalized();
    const bool slides = v.norm() >= options_.min_speed;
    if (slides && !n_) start(sample, v);
    if (slides && n_) {
      learn(f, v, dt);
      turn(f, dt);
    }
  }
  last_ = sample;
  return tracked(sample.time, n_, {});
}

}  // namespace palpate::tactile
