// SPDX-License-Identifier: Apache-2.0
#include "tactile/normals/rls.hpp"

#include "palpate/core/option_check.hpp"
#include "palpate/core/se3.hpp"
#include "tactile/normals/estimate_status.hpp"

namespace palpate::tactile {

RlsEstimator::RlsEstimator(const RlsOptions& options)
    : options_(checked(options)), low_pass_(options.low_pass) {}

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
  const double keep = 1 - options_.decay * dt, take = dt * options_.gain;
  L1_ = keep * L1_ + take / (1 + v.squaredNorm()) * v * v.transpose();
  L2_ = keep * L2_ + take / (1 + w.squaredNorm()) * w * w.transpose();
}

/// Eqs 5.8-5.10.
void RlsEstimator::turn(const Eigen::Vector3d& f, double dt) {
  const Eigen::Vector3d rate = -(options_.gamma1 * L1_ + options_.gamma2 * L2_) * *n_;
  const Eigen::Vector3d omega = n_->cross(rate);
  const double step = options_.literal ? dt / 2 : dt;
  n_ = (exp_so3(step * omega) * *n_).normalized();
  if (!options_.literal && n_->dot(f) > 0) *n_ *= -1;
}

NormalEstimate RlsEstimator::update(const FingerSample& sample) {
  if (!sample.flags.usable()) return held(sample.time, n_, {});
  if (last_ && sample.time - last_->time > options_.forget_after) {
    *this = RlsEstimator(options_);
  }
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
