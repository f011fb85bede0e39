// SPDX-License-Identifier: Apache-2.0
#include "palpate/pipeline/grasp_aim.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

namespace palpate::pipeline {
namespace {

constexpr int kDirections = 36;  // over half a turn

struct Extent {
  double low = std::numeric_limits<double>::infinity();
  double high = -std::numeric_limits<double>::infinity();
  double width() const { return high - low; }
  double middle() const { return (low + high) / 2; }
};

Extent extent_along(const std::vector<Eigen::Vector2d>& points, const Eigen::Vector2d& direction) {
  Extent extent;
  for (const auto& point : points) {
    extent.low = std::min(extent.low, direction.dot(point));
    extent.high = std::max(extent.high, direction.dot(point));
  }
  return extent;
}

}  // namespace

GraspAim aim_from_above(const geometry::TriangleMesh& mesh, const Eigen::Isometry3d& T_world_object,
                        double closing_angle) {
  std::vector<Eigen::Vector2d> shadow;
  for (const auto& vertex : mesh.vertices) shadow.emplace_back((T_world_object * vertex).head<2>());
  const Eigen::Vector2d centroid = T_world_object.translation().head<2>();
  GraspAim aim;
  double narrowest = std::numeric_limits<double>::infinity();
  for (int i = 0; i < kDirections; ++i) {
    const double angle = std::numbers::pi * (i - kDirections / 2) / kDirections;
    const Eigen::Vector2d across(std::cos(angle), std::sin(angle));
    const Extent extent = extent_along(shadow, across);
    if (extent.width() >= narrowest) continue;
    narrowest = extent.width();
    aim.place = centroid + (extent.middle() - across.dot(centroid)) * across;
    aim.yaw = angle - closing_angle;
  }
  return aim;
}

}  // namespace palpate::pipeline
