// SPDX-License-Identifier: Apache-2.0
#include "registration/neighbour_rounds.hpp"

#include <algorithm>
#include <cmath>

#include "palpate/core/parallel.hpp"

namespace palpate::registration {

using geometry::PointCloud;

void append_pair(Correspondences& pairs, const PointCloud& source, std::size_t i,
                 const PointCloud& target, std::size_t j) {
  pairs.source.push_back(source.points[i]);
  pairs.target.push_back(target.points[j]);
  pairs.source_normals.push_back(source.normals[i]);
  pairs.target_normals.push_back(target.normals[j]);
}

Correspondences matched_features(const FeatureCloud& source, const FeatureCloud& target,
                                 int threads) {
  Correspondences pairs;
  for (const auto& match : geometry::mutual_matches(source.features, target.features, threads)) {
    append_pair(pairs, source.cloud, static_cast<std::size_t>(match.source), target.cloud,
                static_cast<std::size_t>(match.target));
  }
  return pairs;
}

NeighbourRounds::NeighbourRounds(const PointCloud& source, const PointCloud& target,
                                 Primitive primitive, const AllowedTurns& turns, int threads)
    : source_(source),
      target_(target),
      tree_(target.points),
      primitive_(primitive),
      turns_(turns),
      threads_(threads),
      nearest_(source.size(), -1),
      partners_(source.size(), -1) {}

const Correspondences& NeighbourRounds::pair_up(const Eigen::Isometry3d& T, double bound,
                                                std::size_t stride) {
  looked_ = (source_.size() + stride - 1) / stride;
  paired_at_ = T;
  find_nearest(T, bound, stride);
  for (auto* list :
       {&pairs_.source, &pairs_.target, &pairs_.source_normals, &pairs_.target_normals}) {
    list->clear();
  }
  for (std::size_t i = 0; i < source_.size(); i += stride) {
    if (partners_[i] < 0) continue;
    append_pair(pairs_, source_, i, target_, static_cast<std::size_t>(partners_[i]));
  }
  return pairs_;
}

PoseEstimate NeighbourRounds::solve() {
  if (primitive_ != Primitive::kPlane) return solve_pose(pairs_, {}, primitive_, turns_);
  own_normals_ = pairs_.target_normals;
  for (std::size_t i = 0; i < pairs_.size(); ++i) {
    Eigen::Vector3d& normal = pairs_.target_normals[i];
    const Eigen::Vector3d other = paired_at_.linear() * pairs_.source_normals[i];
    normal =
        (normal.dot(other) < 0 ? Eigen::Vector3d(normal - other) : normal + other).normalized();
  }
  PoseEstimate estimate = solve_pose(pairs_, {}, primitive_, turns_);
  std::swap(pairs_.target_normals, own_normals_);
  return estimate;
}

double NeighbourRounds::share_within(const Eigen::Isometry3d& T, double bound) const {
  const auto near = std::ranges::count_if(source_.points, [&](const Eigen::Vector3d& p) {
    return tree_.nearest_within(T * p, bound).index >= 0;
  });
  return static_cast<double>(near) / static_cast<double>(source_.size());
}

double NeighbourRounds::share_off_surface(const Eigen::Isometry3d& T, double bound,
                                          std::size_t stride) const {
  constexpr double kReach = 3, kAlong = 0.8, kAlongOther = 0.5;  // bounds, cosines
  double on = 0, off = 0;
  for (std::size_t i = 0; i < source_.size(); i += stride) {
    const Eigen::Vector3d p = T * source_.points[i];
    const auto [index, squared] = tree_.nearest_within(p, kReach * bound);
    if (index < 0) continue;
    const auto j = static_cast<std::size_t>(index);
    const double distance = std::sqrt(squared);
    if (distance < bound) {
      ++on;
      continue;
    }
    const Eigen::Vector3d gap = p - target_.points[j];
    const double along = std::abs(gap.dot(target_.normals[j])) / distance,
                 along_other = std::abs(gap.dot(T.linear() * source_.normals[i])) / distance;
    off += along > kAlong && along_other > kAlongOther;
  }
  return off > 0 ? off / (on + off) : 0;
}

double NeighbourRounds::truncated_cost(const Eigen::Isometry3d& T, double bound) const {
  double sum = static_cast<double>(looked_ - pairs_.size());
  for (const double squared : squared_residuals(pairs_, T, primitive_)) {
    sum += std::min(1.0, squared / (bound * bound));
  }
  return sum / static_cast<double>(looked_);
}

std::vector<double> NeighbourRounds::truncated_costs(const Eigen::Isometry3d& T, double reach,
                                                     double bound) {
  const auto squared = squared_residuals(pair_up(T, reach, 1), T, primitive_);
  std::vector<double> costs(source_.size(), 1);
  for (std::size_t i = 0, pair = 0; i < costs.size(); ++i) {
    if (partners_[i] >= 0) costs[i] = std::min(1.0, squared[pair++] / (bound * bound));
  }
  return costs;
}

void NeighbourRounds::find_nearest(const Eigen::Isometry3d& T, double bound, std::size_t stride) {
  constexpr double kMinCosine = 0.5;
  constexpr std::size_t kBlock = 512;
  parallel_for((looked_ + kBlock - 1) / kBlock, threads_, [&](std::size_t block) {
    const std::size_t end = std::min(looked_, (block + 1) * kBlock);
    for (std::size_t i = block * kBlock * stride; i < source_.size() && i < end * stride;
         i += stride) {
      const int found = nearest_within(T * source_.points[i], bound, nearest_[i]);
      partners_[i] = -1;
      if (found < 0) continue;
      nearest_[i] = found;
      const Eigen::Vector3d& n = target_.normals[static_cast<std::size_t>(found)];
      const double cosine = std::abs((T.linear() * source_.normals[i]).dot(n));
      if (cosine > kMinCosine) partners_[i] = found;
    }
  });
}

/// @param last  nearest in the round before, or -1: what is farther away need not be looked at
int NeighbourRounds::nearest_within(const Eigen::Vector3d& p, double bound, int last) const {
  constexpr double kRounding = 1e-12;
  double reach = bound;
  if (last >= 0) {
    const double distance = (target_.points[static_cast<std::size_t>(last)] - p).norm();
    reach = std::min(bound, distance);
    if (distance >= bound) last = -1;
  }
  const int found = tree_.nearest_within(p, reach * (1 - kRounding)).index;
  return found < 0 ? last : found;
}

}  // namespace palpate::registration
