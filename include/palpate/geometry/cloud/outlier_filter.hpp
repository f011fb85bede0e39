// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "palpate/geometry/cloud/point_cloud.hpp"

namespace palpate::geometry {

/// The thesis' values, 6.3.
struct OutlierFilterOptions {
  int neighbours = 1000;         ///< at least 1; of a smaller cloud all others
  double deviation_ratio = 0.5;  ///< standard deviations above the mean that are kept, > 0
};

/// Points whose mean distance to their nearest neighbours is at most the mean of that of all points
/// plus `deviation_ratio` standard deviations (statistical outlier removal, Rusu et al. 2008).
/// @return indices of the points to keep, ascending
/// @throws BadInput for options out of range, and as check_cloud()
std::vector<int> statistical_inliers(const PointCloud& cloud,
                                     const OutlierFilterOptions& options = {});

}  // namespace palpate::geometry
