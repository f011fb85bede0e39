// SPDX-License-Identifier: Apache-2.0
#include "registration/scorer.hpp"

#include <algorithm>
#include <array>
#include <numeric>

#include "palpate/registration/quadratic_form.hpp"
#include "registration/bitset_rows.hpp"
#include "registration/nearest_rotation.hpp"

namespace palpate::registration {
namespace {

constexpr int kBlock = 512;  // on the stack: gains are asked for more often than anything else

struct Motion {
  const float* R;  // columns one after the other
  const float* t;
  float scale;  // of the squares
};

struct Span {
  int from, to, shift;
};

/// result[i - from] += scale |R a_i + t - b_(i + shift)|^2.
PALPATE_WIDE void add_squares(const Eigen::ArrayXf (&a)[3], const Eigen::ArrayXf (&b)[3],
                              const Motion& motion, const Span& span, float* __restrict result) {
  const float *ax = a[0].data(), *ay = a[1].data(), *az = a[2].data();
  const float *bx = b[0].data() + span.shift, *by = b[1].data() + span.shift,
              *bz = b[2].data() + span.shift;
  const float* R = motion.R;
  const float r00 = R[0], r10 = R[1], r20 = R[2], r01 = R[3], r11 = R[4], r21 = R[5], r02 = R[6],
              r12 = R[7], r22 = R[8], tx = motion.t[0], ty = motion.t[1], tz = motion.t[2];
  const float scale = motion.scale;
  for (int i = span.from; i < span.to; ++i) {
    const float dx = r00 * ax[i] + r01 * ay[i] + r02 * az[i] + (tx - bx[i]);
    const float dy = r10 * ax[i] + r11 * ay[i] + r12 * az[i] + (ty - by[i]);
    const float dz = r20 * ax[i] + r21 * ay[i] + r22 * az[i] + (tz - bz[i]);
    result[i - span.from] += scale * (dx * dx + dy * dy + dz * dz);
  }
}

}  // namespace

Scorer::Scorer(const Correspondences& correspondences, double noise_bound, double chord_bound,
               const AllowedTurns& turns)
    : unit_(noise_bound), chord_bound_(static_cast<float>(chord_bound)), turns_(turns) {
  if (turns_.axis) turns_.axis->normalize();
  const Origins means = weighted_means(correspondences, {});
  source_origin_ = means.source;
  target_origin_ = means.target;
  columns_ = std::make_shared<const PairColumns>(
      columns_of(correspondences, source_origin_, target_origin_, unit_, chord_bound > 0));
}

/// Squared residuals, in squared bounds, of the sources from..to-1 moved by T, each held against
/// the target `shift` places on.
void Scorer::squares(const Eigen::Isometry3d& T, int from, int to, int shift, float* result) const {
  const Eigen::Matrix3f R = T.linear().cast<float>();
  const Eigen::Vector3f t = T.translation().cast<float>();
  std::fill(result, result + (to - from), 0.0F);
  add_squares(columns_->s, columns_->t, {R.data(), t.data(), 1}, {from, to, shift}, result);
  if (chord_bound_ > 0) {
    constexpr float kStill[3] = {0, 0, 0};
    add_squares(columns_->n, columns_->m, {R.data(), kStill, 1 / (chord_bound_ * chord_bound_)},
                {from, to, shift}, result);
  }
}

Eigen::ArrayXf Scorer::squares(const Eigen::Isometry3d& T, int from, int to, int shift) const {
  Eigen::ArrayXf result(to - from);
  squares(T, from, to, shift, result.data());
  return result;
}

Eigen::ArrayXf Scorer::gains(const Eigen::Isometry3d& T, float reach) const {
  return (1 - squares(T, 0, size(), 0) / (reach * reach)).max(0.0F);
}

double Scorer::gain(const Eigen::Isometry3d& T) const {
  float block[kBlock];
  double sum = 0;
  for (int from = 0; from < size(); from += kBlock) {
    const int to = std::min(size(), from + kBlock);
    squares(T, from, to, 0, block);
    const Eigen::Map<const Eigen::ArrayXf> off(block, to - from);
    sum += static_cast<double>((1 - off).max(0.0F).sum());
  }
  return sum;
}

/// Pairs within `reach` times the bounds of the sources from..to-1.
int Scorer::count_within(const Eigen::Isometry3d& T, int from, int to, int shift,
                         float reach) const {
  float block[kBlock];
  int count = 0;
  for (; from < to; from += kBlock) {
    const int end = std::min(to, from + kBlock);
    squares(T, from, end, shift, block);
    const Eigen::Map<const Eigen::ArrayXf> off(block, end - from);
    count += static_cast<int>((off < reach * reach).count());
  }
  return count;
}

double Scorer::gain_of(const std::vector<int>& indices, const Eigen::Isometry3d& T) const {
  double sum = 0;
  for (const int i : indices) {
    float off = 0;
    squares(T, i, i + 1, 0, &off);
    sum += std::max(0.0, 1 - static_cast<double>(off));
  }
  return sum;
}

Score Scorer::score(const Eigen::Isometry3d& T) const {
  const Eigen::ArrayXf all = gains(T);
  Score score;
  score.gain = static_cast<double>(all.sum());
  score.count = static_cast<int>((all > 0).count());
  return score;
}

Score Scorer::score_of_distinct(const Eigen::Isometry3d& T) const {
  constexpr int kMost = 256;
  const Eigen::ArrayXf all = gains(T);
  std::vector<std::array<float, 7>> inliers;  // points and gain
  for (int i = 0; i < size(); ++i) {
    if (!(all[i] > 0)) continue;
    const auto &s = columns_->s, &t = columns_->t;
    inliers.push_back({s[0][i], s[1][i], s[2][i], t[0][i], t[1][i], t[2][i], all[i]});
  }
  const auto alike = [](const auto& a, const auto& b) {
    return std::equal(a.begin(), a.end() - 1, b.begin());
  };
  if (inliers.size() <= kMost) {
    std::ranges::sort(inliers);
    inliers.erase(std::unique(inliers.begin(), inliers.end(), alike), inliers.end());
  }
  Score score;
  score.count = static_cast<int>(inliers.size());
  for (const auto& inlier : inliers) score.gain += static_cast<double>(inlier.back());
  return score;
}

Score Scorer::score_of_separate(const Eigen::Isometry3d& T, float radius,
                                std::size_t looked) const {
  constexpr std::size_t kEnough = 64;
  const Eigen::ArrayXf all = gains(T);
  std::vector<int> inliers, kept;
  for (int i = 0; i < size(); ++i) {
    if (all[i] > 0) inliers.push_back(i);
  }
  // Neighbours in the list are often neighbours in space: a stride reaches all parts soon.
  const std::size_t count = inliers.size();
  std::size_t stride = std::max<std::size_t>(1, count * 618 / 1000);
  while (std::gcd(stride, count) > 1) ++stride;
  Score score;
  for (std::size_t k = 0, next = 0; k < std::min(count, looked) && kept.size() < kEnough; ++k) {
    const int i = inliers[next];
    next = (next + stride) % count;
    const auto close = [&](int j) { return are_near(*columns_, i, j, radius * radius); };
    if (std::ranges::any_of(kept, close)) continue;
    kept.push_back(i);
    score.gain += static_cast<double>(all[i]);
  }
  score.count = static_cast<int>(kept.size());
  return score;
}

Scorer Scorer::over(const PairColumns& columns) const {
  Scorer result = *this;
  result.columns_ = {std::shared_ptr<const void>(), &columns};
  return result;
}

Scorer Scorer::without_normals() const {
  Scorer result = *this;
  result.chord_bound_ = 0;
  return result;
}

std::vector<int> Scorer::near(const Eigen::Isometry3d& T, float reach) const {
  const Eigen::ArrayXf off = squares(T, 0, size(), 0);
  std::vector<int> indices;
  for (Eigen::Index i = 0; i < off.size(); ++i) {
    if (off[i] < reach * reach) indices.push_back(static_cast<int>(i));
  }
  return indices;
}

Eigen::Isometry3d Scorer::align_inliers(const Eigen::ArrayXf& gains, double sign) const {
  std::vector<int> inliers;
  for (Eigen::Index i = 0; i < gains.size(); ++i) {
    if (gains[i] > 0) inliers.push_back(static_cast<int>(i));
  }
  return align(inliers, sign);
}

double Scorer::descend(Eigen::Isometry3d& T, float reach) const {
  constexpr int kMaxSteps = 10;
  const double sign = T.linear().determinant() < 0 ? -1 : 1;
  Eigen::ArrayXf current = gains(T, reach);
  auto best = static_cast<double>(current.sum());
  for (int step = 0; step < kMaxSteps; ++step) {
    const Eigen::Isometry3d next = align_inliers(current, sign);
    current = gains(next, reach);
    const auto reached = static_cast<double>(current.sum());
    if (!(reached > best)) break;
    const bool settled = reached < best * (1 + 1e-4);
    best = reached;
    T = next;
    if (settled) break;
  }
  return best;
}

/// Least squares of the sources, the first axis times `sign`.
Eigen::Isometry3d Scorer::align(const std::vector<int>& indices, double sign) const {
  const double count = static_cast<double>(indices.size());
  Eigen::Vector3d x = Eigen::Vector3d::Zero(), y = x;
  for (const int i : indices) {
    for (int a = 0; a < 3; ++a) {
      x[a] += static_cast<double>(columns_->s[a][i]);
      y[a] += static_cast<double>(columns_->t[a][i]);
    }
  }
  x /= count;
  y /= count;
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  double squares = 0;
  for (const int i : indices) {
    const Eigen::Vector3d p = at(columns_->s, i).cast<double>();
    const Eigen::Vector3d q = at(columns_->t, i).cast<double>();
    covariance.noalias() += (q - y) * (p - x).transpose();
    squares += (q - y).squaredNorm() + (p - x).squaredNorm();
  }
  covariance.col(0) *= sign;
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  if (turns_.axis) {
    T.linear() = rotation_about(*turns_.axis, covariance);
  } else if (!turns_.none) {
    T.linear() = rotation_between(covariance, 0.5 * squares);
  }
  T.linear().col(0) *= sign;
  T.translation() = y - T.linear() * x;
  return T;
}

Eigen::Isometry3d Scorer::align(const std::vector<int>& indices) const { return align(indices, 1); }

Eigen::Isometry3d Scorer::align_mirrored(const std::vector<int>& indices) const {
  return align(indices, -1);
}

int Scorer::count_shifted(const Eigen::Isometry3d& T, int shift, float reach) const {
  // The last sources meet the first targets.
  const int n = size();
  return count_within(T, 0, n - shift, shift, reach) +
         count_within(T, n - shift, n, shift - n, reach);
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
