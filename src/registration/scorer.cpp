// SPDX-License-Identifier: Apache-2.0
#include "scorer.hpp"

#include <array>

#include "nearest_rotation.hpp"
#include "palpate/registration/quadratic_form.hpp"

namespace palpate::registration {
namespace {

void split(const std::vector<Eigen::Vector3d>& points, const Eigen::Vector3d& origin, double unit,
           Eigen::ArrayXf (&axes)[3]) {
  const auto count = static_cast<Eigen::Index>(points.size());
  for (auto& axis : axes) axis.resize(count);
  for (Eigen::Index i = 0; i < count; ++i) {
    const Eigen::Vector3f p = ((points[static_cast<std::size_t>(i)] - origin) / unit).cast<float>();
    for (int a = 0; a < 3; ++a) axes[a][i] = p[a];
  }
}

}  // namespace

Scorer::Scorer(const Correspondences& correspondences, double noise_bound, double chord_bound)
    : unit_(noise_bound), chord_bound_(static_cast<float>(chord_bound)) {
  const Origins means = weighted_means(correspondences, {});
  source_origin_ = means.source;
  target_origin_ = means.target;
  split(correspondences.source, source_origin_, unit_, x_);
  split(correspondences.target, target_origin_, unit_, y_);
  if (chord_bound <= 0) return;
  split(correspondences.source_normals, Eigen::Vector3d::Zero(), 1, n_);
  split(correspondences.target_normals, Eigen::Vector3d::Zero(), 1, m_);
}

Eigen::ArrayXf Scorer::gains(const Eigen::Isometry3d& T) const {
  const Eigen::Matrix3f R = T.linear().cast<float>();
  const Eigen::Vector3f t = T.translation().cast<float>();
  const auto off = [&](int a) {
    return (R(a, 0) * x_[0] + R(a, 1) * x_[1] + R(a, 2) * x_[2] + (t[a] - y_[a])).square();
  };
  Eigen::ArrayXf result = 1 - (off(0) + off(1) + off(2));
  if (chord_bound_ > 0) {
    const float scale = 1 / (chord_bound_ * chord_bound_);
    for (int a = 0; a < 3; ++a) {
      result -= scale * (R(a, 0) * n_[0] + R(a, 1) * n_[1] + R(a, 2) * n_[2] - m_[a]).square();
    }
  }
  return result.max(0.0F);
}

double Scorer::gain(const Eigen::Isometry3d& T) const {
  return static_cast<double>(gains(T).sum());
}

Score Scorer::score(const Eigen::Isometry3d& T) const {
  const Eigen::ArrayXf all = gains(T);
  Score score;
  score.gain = static_cast<double>(all.sum());
  score.count = static_cast<int>((all > 0).count());
  return score;
}

Eigen::Isometry3d Scorer::align_weighted(const Eigen::ArrayXf& weights) const {
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  const auto sum = static_cast<double>(weights.sum());
  if (sum <= 0) return T;
  Eigen::Vector3d x, y;
  Eigen::Matrix3d covariance;
  for (int a = 0; a < 3; ++a) {
    x[a] = static_cast<double>((weights * x_[a]).sum()) / sum;
    y[a] = static_cast<double>((weights * y_[a]).sum()) / sum;
  }
  for (int a = 0; a < 3; ++a) {
    const Eigen::ArrayXf row = weights * (y_[a] - static_cast<float>(y[a]));
    for (int b = 0; b < 3; ++b) covariance(a, b) = static_cast<double>((row * x_[b]).sum());
  }
  T.linear() = nearest_rotation(covariance);
  T.translation() = y - T.linear() * x;
  return T;
}

double Scorer::descend(Eigen::Isometry3d& T) const {
  constexpr int kMaxSteps = 10;
  Eigen::ArrayXf current = gains(T);
  auto best = static_cast<double>(current.sum());
  for (int step = 0; step < kMaxSteps; ++step) {
    const Eigen::Isometry3d next = align_weighted((current > 0).cast<float>());
    current = gains(next);
    const auto reached = static_cast<double>(current.sum());
    if (!(reached > best)) break;
    const bool settled = reached < best * (1 + 1e-4);
    best = reached;
    T = next;
    if (settled) break;
  }
  return best;
}

Eigen::Isometry3d Scorer::align(const std::vector<int>& indices) const {
  const double count = static_cast<double>(indices.size());
  Eigen::Vector3d x = Eigen::Vector3d::Zero(), y = x;
  for (const int i : indices) {
    for (int a = 0; a < 3; ++a) {
      x[a] += static_cast<double>(x_[a][i]);
      y[a] += static_cast<double>(y_[a][i]);
    }
  }
  x /= count;
  y /= count;
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  for (const int i : indices) {
    const Eigen::Vector3d p = Eigen::Vector3f(x_[0][i], x_[1][i], x_[2][i]).cast<double>();
    const Eigen::Vector3d q = Eigen::Vector3f(y_[0][i], y_[1][i], y_[2][i]).cast<double>();
    covariance.noalias() += (q - y) * (p - x).transpose();
  }
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.linear() = nearest_rotation(covariance);
  T.translation() = y - T.linear() * x;
  return T;
}

int Scorer::count_shifted(const Eigen::Isometry3d& T, int shift) const {
  const Eigen::Matrix3f R = T.linear().cast<float>();
  const Eigen::Vector3f t = T.translation().cast<float>();
  const float scale = chord_bound_ > 0 ? 1 / (chord_bound_ * chord_bound_) : 0;
  int count = 0;
  // Sources 0 .. n-shift-1 with targets from `shift` on, then the rest with those from the start.
  const Eigen::Index n = size();
  for (const auto& [from, to, length] :
       {std::array<Eigen::Index, 3>{0, shift, n - shift}, {n - shift, 0, shift}}) {
    Eigen::ArrayXf off = Eigen::ArrayXf::Zero(length);
    for (int a = 0; a < 3; ++a) {
      off += (R(a, 0) * x_[0].segment(from, length) + R(a, 1) * x_[1].segment(from, length) +
              R(a, 2) * x_[2].segment(from, length) + (t[a] - y_[a].segment(to, length)))
                 .square();
      if (scale > 0) {
        off +=
            scale * (R(a, 0) * n_[0].segment(from, length) + R(a, 1) * n_[1].segment(from, length) +
                     R(a, 2) * n_[2].segment(from, length) - m_[a].segment(to, length))
                        .square();
      }
    }
    count += static_cast<int>((off < 1).count());
  }
  return count;
}

Eigen::Isometry3d Scorer::uncentred(const Eigen::Isometry3d& T) const {
  Eigen::Isometry3d result = T;
  result.translation() = target_origin_ + unit_ * T.translation() - T.linear() * source_origin_;
  return result;
}

Eigen::Isometry3d Scorer::centred(const Eigen::Isometry3d& T) const {
  Eigen::Isometry3d result = T;
  result.translation() = (T * source_origin_ - target_origin_) / unit_;
  return result;
}

}  // namespace palpate::registration
