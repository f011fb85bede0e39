// SPDX-License-Identifier: Apache-2.0
#include "free_space_term.hpp"

#include <algorithm>
#include <cmath>

namespace palpate::localization {
namespace {

constexpr double kSlack = 0.0005;  // m; the balls only approximate the hand, so they are shrunk

/// The order in which each ball is the farthest from those before it.
std::vector<FreeSphere> spread_first(std::vector<FreeSphere> spheres) {
  std::vector<double> gap(spheres.size(), std::numeric_limits<double>::infinity());
  for (std::size_t i = 1; i < spheres.size(); ++i) {
    std::size_t farthest = i;
    for (std::size_t j = i; j < spheres.size(); ++j) {
      gap[j] = std::min(gap[j], (spheres[j].center - spheres[i - 1].center).squaredNorm());
      if (gap[j] > gap[farthest]) farthest = j;
    }
    std::swap(spheres[i], spheres[farthest]);
    std::swap(gap[i], gap[farthest]);
  }
  return spheres;
}

double bounding_radius(const geometry::TriangleMesh& mesh) {
  double squared = 0;
  for (const auto& vertex : mesh.vertices) squared = std::max(squared, vertex.squaredNorm());
  return std::sqrt(squared);
}

}  // namespace

FreeSpaceTerm::FreeSpaceTerm(const ObjectModel& model, const Evidence& evidence,
                             std::shared_ptr<const Clearance> clearance, double scale)
    : field_(model.field()),
      clearance_(std::move(clearance)),
      half_precision_(static_cast<float>(0.5 / std::pow(scale * evidence.penetration_sigma, 2))) {
  const double object_radius = bounding_radius(model.object().mesh);
  for (const FreeSphere& sphere : spread_first(evidence.free_space)) {
    const double radius = std::max(0.0, sphere.radius - kSlack);
    balls_.push_back({sphere.center.cast<float>(), static_cast<float>(radius),
                      static_cast<float>(std::pow(object_radius + radius, 2))});
  }
}

float FreeSpaceTerm::energy(const SearchPose& pose, float bound) const {
  const Eigen::Matrix3f R_object_frame = pose.R.transpose();
  float sum = 0;
  for (const Ball& ball : balls_) {
    const Eigen::Vector3f arm = ball.center - pose.t;
    if (arm.squaredNorm() > ball.reach_squared) continue;
    const Eigen::Vector3f center = R_object_frame * arm;
    if (clearance_->at_least(center) >= ball.radius) continue;
    const float depth = ball.radius - field_.distance(center);
    if (depth <= 0) continue;
    sum += depth * depth * half_precision_;
    if (sum > bound) break;
  }
  return sum;
}

}  // namespace palpate::localization
