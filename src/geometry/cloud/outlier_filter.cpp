// SPDX-License-Identifier: Apache-2.0
#include "palpate/geometry/cloud/outlier_filter.hpp"

#include <fmt/format.h>

#include <cmath>

#include "palpate/core/error.hpp"
#include "palpate/core/statistics.hpp"
#include "palpate/geometry/cloud/kd_tree.hpp"

namespace palpate::geometry {

std::vector<int> statistical_inliers(const PointCloud& cloud, const OutlierFilterOptions& options) {
  if (options.neighbours < 1) {
    throw BadInput(fmt::format("{} neighbours are fewer than one", options.neighbours));
  }
  if (!(options.deviation_ratio > 0)) {
    throw BadInput(fmt::format("deviation ratio {} is not positive", options.deviation_ratio));
  }
  check_cloud(cloud);
  std::vector<int> kept;
  if (cloud.size() < 3) {  // no deviation to speak of
    for (std::size_t i = 0; i < cloud.size(); ++i) kept.push_back(static_cast<int>(i));
    return kept;
  }
  const KdTree tree(cloud.points);
  std::vector<double> distances;
  for (const auto& p : cloud.points) {
    const auto found = tree.nearest(p, options.neighbours + 1);  // the point itself comes first
    double sum = 0;
    for (const auto& neighbour : found) sum += std::sqrt(neighbour.squared_distance);
    distances.push_back(sum / static_cast<double>(found.size() - 1));
  }
  const double most = mean(distances) + options.deviation_ratio * standard_deviation(distances);
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    if (distances[i] <= most) kept.push_back(static_cast<int>(i));
  }
  return kept;
}

}  // namespace palpate::geometry
