// SPDX-License-Identifier: Apache-2.0
#include "palpate/touch/s2_filter.hpp"

#include <cmath>

#include "estimate_status.hpp"
#include "palpate/core/se3.hpp"

namespace palpate::touch {

S2Filter::S2Filter(const S2Options& options)
    : options_(options),
      force_noise_(0.05, 1e-3, 100),
      point_noise_(3e-4, 1e-6, 100),
      tip_noise_(0.1, 0.01, 100) {}

void S2Filter::start(const FingerSample& s) {
  const Eigen::Vector3d n = s.tip_normal ? *s.tip_normal : Eigen::Vector3d(-s.f.normalized());
  R_ = frame_with_z(n);
  m_.setZero();
  c_.setZero();
  p_ = s.p;
  Vector sigma;
  sigma << options_.start_sigma, options_.start_sigma, 0.5, 0.5, 0.03, 0.03,
      Eigen::Vector3d::Constant(1e-3);
  P_ = sigma.cwiseAbs2().asDiagonal();
  mode_ = {0.9, 0.05, 0.05};
  started_ = true;
}

void S2Filter::predict(double dt) {
  const Eigen::Matrix<double, 3, 2> B = R_.leftCols<2>();
  p_ += dt * B * c_;
  Matrix F = Matrix::Identity();
  F.block<3, 2>(6, 0) = -dt * R_.col(2) * c_.transpose();
  F.block<3, 2>(6, 4) = dt * B;
  P_ = (F * P_ * F.transpose()).eval();
}

int S2Filter::measure(const FingerSample& s, std::array<Row, 8>& rows) const {
  int count = 0;
  const auto add = [&](const Vector& h, double r, double sigma, bool gated) {
    rows[static_cast<std::size_t>(count++)] = {h, r, sigma * sigma, gated};
  };
  const Eigen::Vector3d g = R_.transpose() * s.f;
  if (-g.z() > 0.2 * g.norm()) {
    const Eigen::Vector2d z = g.head<2>() / -g.z();
    const double sigma = force_noise_.sigma() / -g.z();
    const Eigen::Vector2d along = z.norm() > 1e-6 ? z.normalized() : Eigen::Vector2d::UnitX();
    const Eigen::Vector2d across(-along.y(), along.x());
    const double lean = 1 + z.squaredNorm();
    Vector h = Vector::Zero();
    h.head<2>() = -lean * along;
    h.segment<2>(2) = along;
    add(h, along.dot(z - m_), sigma * std::sqrt(lean), false);
    h.head<2>() = -across;
    h.segment<2>(2) = across;
    add(h, across.dot(z - m_), sigma, false);
  }
  if (s.tip_normal) {
    const Eigen::Vector3d t = R_.transpose() * *s.tip_normal;
    const Eigen::Vector2d y = t.head<2>() / std::max(t.z(), 0.2);
    for (int i = 0; i < 2; ++i) {
      Vector h = Vector::Zero();
      h[i] = 1;
      add(h, y[i], tip_noise_.sigma(), true);
    }
  }
  for (int i = 0; i < 3; ++i) {
    Vector h = Vector::Zero();
    h[6 + i] = 1;
    add(h, s.p[i] - p_[i], point_noise_.sigma(), true);
  }
  const double speed = c_.norm();
  const double speed_sigma = std::sqrt(P_.block<2, 2>(4, 4).trace());
  if (speed > 2 * speed_sigma) {
    const Eigen::Vector2d u = c_ / speed;
    Vector h = Vector::Zero();
    const double cross = m_.x() * u.y() - m_.y() * u.x();
    h.segment<2>(2) << u.y(), -u.x();
    h.segment<2>(4) << (-m_.y() - cross * u.x()) / speed, (m_.x() - cross * u.y()) / speed;
    add(h, -cross, options_.coupling, true);
  }
  return count;
}

void S2Filter::correct(double dt, const std::array<Row, 8>& rows, int count) {
  const double speed = std::max(c_.norm(), 1e-4);
  const double turning = m_.norm() * options_.acceleration / speed;
  struct Process {
    double tilt, ratio, acceleration;
  };
  const double ratio = std::min(std::hypot(options_.ratio_rate, turning), options_.turn_ratio_rate);
  const std::array<Process, kModes> processes = {{
      {options_.tilt_rate, ratio, options_.acceleration},
      {options_.edge_tilt_rate, ratio, options_.acceleration},
      {options_.tilt_rate, options_.turn_ratio_rate, options_.turn_acceleration},
  }};
  // Markov prior
  std::array<double, kModes> prior;
  const std::array<double, kModes> fresh = {1 - options_.p_edge - options_.p_turn, options_.p_edge,
                                            options_.p_turn};
  const double s = options_.p_stay;
  const double leaving = (1 - s) * (mode_[1] + mode_[2]) + mode_[0];
  prior[0] = fresh[0] * leaving;
  prior[1] = fresh[1] * leaving + s * mode_[1];
  prior[2] = fresh[2] * leaving + s * mode_[2];

  std::array<Vector, kModes> dx;
  std::array<Matrix, kModes> P;
  std::array<double, kModes> log_weight;
  for (std::size_t k = 0; k < kModes; ++k) {
    dx[k].setZero();
    P[k] = P_;
    const auto q = [&](double rate) { return rate * rate * dt; };
    P[k].diagonal().segment<2>(0).array() += q(processes[k].tilt);
    P[k].diagonal().segment<2>(2).array() += q(processes[k].ratio);
    P[k].diagonal().segment<2>(4).array() += q(processes[k].acceleration);
    log_weight[k] = std::log(prior[k]);
    for (int i = 0; i < count; ++i) {
      const Row& row = rows[static_cast<std::size_t>(i)];
      const Vector Ph = P[k] * row.h;
      const double r = row.residual - row.h.dot(dx[k]);
      double S = row.h.dot(Ph) + row.variance;
      if (row.gated && r * r > 6 * S) S = r * r / 6;
      log_weight[k] -= 0.5 * (r * r / S + std::log(S));
      dx[k] += Ph * (r / S);
      P[k] -= Ph * Ph.transpose() / S;
    }
  }
  const double top = *std::max_element(log_weight.begin(), log_weight.end());
  double sum = 0;
  for (std::size_t k = 0; k < kModes; ++k) sum += mode_[k] = std::exp(log_weight[k] - top);
  Vector mean = Vector::Zero();
  for (std::size_t k = 0; k < kModes; ++k) {
    mode_[k] /= sum;
    mean += mode_[k] * dx[k];
  }
  P_.setZero();
  for (std::size_t k = 0; k < kModes; ++k) {
    const Vector d = dx[k] - mean;
    P_ += mode_[k] * (P[k] + d * d.transpose());
  }
  retract(mean);
}

void S2Filter::retract(const Vector& dx) {
  R_ = R_ * exp_so3({-dx[1], dx[0], 0});
  m_ += dx.segment<2>(2);
  c_ += dx.segment<2>(4);
  p_ += dx.tail<3>();
}

NormalEstimate S2Filter::update(const FingerSample& s) {
  if (!s.flags.usable()) {
    return held(s.time, started_ ? std::optional<Eigen::Vector3d>(R_.col(2)) : std::nullopt, {});
  }
  const bool anew = !started_ || s.time - time_ > options_.forget_after;
  force_noise_.add(s.f);
  point_noise_.add(s.p);
  if (s.tip_normal) tip_noise_.add(*s.tip_normal);
  if (anew) {
    start(s);
  } else {
    const double dt = s.time - time_;
    predict(dt);
    std::array<Row, 8> rows;
    const int count = measure(s, rows);
    correct(dt, rows, count);
  }
  time_ = s.time;
  const Eigen::Matrix<double, 3, 2> B = R_.leftCols<2>();
  return tracked(s.time, Eigen::Vector3d(R_.col(2)),
                 Eigen::Matrix3d(B * P_.topLeftCorner<2, 2>() * B.transpose()));
}

}  // namespace palpate::touch
