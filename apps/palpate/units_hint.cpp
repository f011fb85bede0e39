// SPDX-License-Identifier: Apache-2.0
#include "units_hint.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace palpate::app {
namespace {

constexpr double kRatio = 100, kBounds = 1e4;

}  // namespace

double extent_of(const std::vector<Eigen::Vector3d>& points) {
  if (points.empty()) return 0;
  Eigen::Vector3d low = points.front(), high = points.front();
  for (const auto& p : points) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  return (high - low).stableNorm();
}

std::string units_hint(const std::vector<Eigen::Vector3d>& source,
                       const std::vector<Eigen::Vector3d>& target, double noise_bound) {
  if (std::min(source.size(), target.size()) < 3) {
    return fmt::format("the source has {} and the target {} points; three are the least",
                       source.size(), target.size());
  }
  const double from = extent_of(source), to = extent_of(target);
  if (!(std::min(from, to) > 0)) {
    return fmt::format("the points of the {} are all the same", from > 0 ? "target" : "source");
  }
  if (std::max(from, to) > kRatio * std::min(from, to)) {
    return fmt::format(
        "the source measures {:.3g} m and the target {:.3g} m; is one of them in millimetres?",
        from, to);
  }
  if (noise_bound > 0 && std::max(from, to) > kBounds * noise_bound) {
    return fmt::format(
        "the points spread over {:.3g} m, but the noise bound is {:g} m; are they in millimetres?",
        std::max(from, to), noise_bound);
  }
  if (noise_bound > std::min(from, to)) {
    return fmt::format("the noise bound is {:g} m, but the points spread over {:.3g} m only",
                       noise_bound, std::min(from, to));
  }
  return "";
}

}  // namespace palpate::app
