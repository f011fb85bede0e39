// SPDX-License-Identifier: Apache-2.0
#include "registration/usable_pairs.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <span>

namespace palpate::registration {
namespace {

constexpr std::size_t kMaxSearched = 4000;

double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

/// Distances to the median point of those that `indices` names.
std::vector<double> distances(const std::vector<Eigen::Vector3d>& points,
                              const std::vector<int>& indices) {
  std::vector<double> values(indices.size());
  Eigen::Vector3d center;
  for (int a = 0; a < 3; ++a) {
    for (std::size_t k = 0; k < indices.size(); ++k) {
      values[k] = points[static_cast<std::size_t>(indices[k])][a];
    }
    center[a] = median(values);
  }
  for (std::size_t k = 0; k < indices.size(); ++k) {
    values[k] = (points[static_cast<std::size_t>(indices[k])] - center).norm();
  }
  return values;
}

bool is_wide(const std::vector<Eigen::Vector3d>& points, double size) {
  return std::ranges::any_of(
      points, [&](const auto& p) { return (p - points.front()).cwiseAbs().maxCoeff() > size; });
}

/// Drops the pairs whose point is a thousand times as far out as half of the others are.
void drop_far(const std::vector<Eigen::Vector3d>& points, double noise_bound,
              std::vector<int>& indices) {
  constexpr double kPrecise = 1e5, kFar = 1e3;  // noise bounds; medians
  if (indices.size() < 3 || !is_wide(points, kPrecise * noise_bound)) return;
  const std::vector<double> out = distances(points, indices);
  const double limit = kFar * std::max(median(out), noise_bound);
  std::size_t kept = 0;
  for (std::size_t k = 0; k < indices.size(); ++k) {
    if (out[k] <= limit) indices[kept++] = indices[k];
  }
  indices.resize(kept);
}

/// `count` of the indices at random, those of more weight more often, ascending (Efraimidis &
/// Spirakis 2006).
void choose(const std::vector<double>& weights, std::size_t count, RandomStream random,
            std::vector<int>& indices) {
  std::vector<std::pair<double, int>> keys;
  for (const int i : indices) {
    const double weight = weights.empty() ? 1 : weights[static_cast<std::size_t>(i)];
    keys.emplace_back(-std::log(1 - random.uniform()) / weight, i);
  }
  std::ranges::nth_element(keys, keys.begin() + static_cast<std::ptrdiff_t>(count));
  indices.resize(count);
  for (std::size_t k = 0; k < count; ++k) indices[k] = keys[k].second;
  std::ranges::sort(indices);
}

}  // namespace

Correspondences search_sample(const Correspondences& correspondences, double noise_bound,
                              const RandomStream& random) {
  const auto& weights = correspondences.weights;
  std::vector<int> indices(correspondences.size());
  std::iota(indices.begin(), indices.end(), 0);
  if (!weights.empty()) {
    std::erase_if(indices, [&](int i) { return weights[static_cast<std::size_t>(i)] == 0; });
  }
  drop_far(correspondences.source, noise_bound, indices);
  drop_far(correspondences.target, noise_bound, indices);
  if (indices.size() > kMaxSearched) {
    choose(weights, kMaxSearched, random.fork("search sample"), indices);
  }
  if (indices.size() == correspondences.size()) return correspondences;
  return subset(correspondences, indices);
}

}  // namespace palpate::registration
