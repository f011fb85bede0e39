// SPDX-License-Identifier: Apache-2.0
#include "localization/likelihood/free_space_term.hpp"

#include <algorithm>
#include <cmath>

#include "localization/likelihood/hypothesis.hpp"

namespace palpate::localization {
namespace {

constexpr double kSlack = 0.0005;  // m; the balls only approximate the hand, so they are shrunk

constexpr double kStandOut = 0.002;   // m by which a ball must stand out of another to count
constexpr std::size_t kFewest = 100;  // balls that are looked at even where the noise is enlarged

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

/// Leaves out balls that hardly stand out of a larger or earlier one.
std::vector<FreeSphere> without_covered(std::vector<FreeSphere> spheres) {
  std::stable_sort(spheres.begin(), spheres.end(),
                   [](const FreeSphere& a, const FreeSphere& b) { return a.radius > b.radius; });
  std::vector<FreeSphere> kept;
  for (const FreeSphere& sphere : spheres) {
    const bool covered = std::any_of(kept.begin(), kept.end(), [&](const FreeSphere& other) {
      const double room = other.radius + kStandOut - sphere.radius;
      return room > 0 && (other.center - sphere.center).squaredNorm() < room * room;
    });
    if (!covered) kept.push_back(sphere);
  }
  return kept;
}

/// Contacts that share an offset come from a hand that is off by it, and so are its balls.
double depth_variance(const Evidence& evidence, double scale) {
  double offset = 0;
  for (const CommonModeBias& shared : evidence.offsets) offset = std::max(offset, shared.sigma);
  return std::pow(scale * evidence.penetration_sigma, 2) + offset * offset;
}

/// Of the object's relative growth, as far as it is taken into account.
double growth_variance(const Evidence& evidence) {
  double variance = 0;
  for (const Hypothesis& a : hypotheses(evidence)) variance += a.share * a.growth * a.growth;
  return variance;
}

double bounding_radius(const geometry::TriangleMesh& mesh) {
  double squared = 0;
  for (const auto& vertex : mesh.vertices) squared = std::max(squared, vertex.squaredNorm());
  return std::sqrt(squared);
}

}  // namespace

FreeSpaceTerm::Balls::Balls(const geometry::ObjectModel& model, const Evidence& evidence) {
  const double object_radius = bounding_radius(model.object().mesh);
  for (const FreeSphere& sphere : spread_first(without_covered(evidence.free_space))) {
    const double radius = std::max(0.0, sphere.radius - kSlack);
    balls.push_back({sphere.center.cast<float>(), static_cast<float>(radius),
                     static_cast<float>(std::pow(object_radius + radius, 2))});
  }
}

FreeSpaceTerm::FreeSpaceTerm(const geometry::ObjectModel& model, const Evidence& evidence,
                             std::shared_ptr<const Balls> balls, double scale)
    : field_(model.field()),
      clearance_(model.clearance()),
      shared_(std::move(balls)),
      variance_(static_cast<float>(depth_variance(evidence, scale))),
      growth_variance_(static_cast<float>(growth_variance(evidence))) {
  const auto all = static_cast<double>(shared_->balls.size());
  const auto few = static_cast<std::size_t>(all / (scale * scale));
  count_ = std::min(shared_->balls.size(), std::max(kFewest, few));
}

float FreeSpaceTerm::energy(const SearchPose& pose, float bound) const {
  const Eigen::Matrix3f R_object_frame = pose.R.transpose();
  float sum = 0;
  for (std::size_t j = 0; j < count_; ++j) {
    const Ball& ball = shared_->balls[j];
    const Eigen::Vector3f arm = ball.center - pose.t;
    if (arm.squaredNorm() > ball.reach_squared) continue;
    const Eigen::Vector3f center = R_object_frame * arm;
    if (clearance_.at_least(center) >= ball.radius) continue;
    float distance = field_.distance(center);
    if (distance >= field_.beyond()) distance = field_.anywhere(center).distance;
    const float depth = ball.radius - distance;
    if (depth <= 0) continue;
    sum += 0.5F * depth * depth / (variance_ + growth_variance_ * arm.squaredNorm());
    if (sum > bound) break;
  }
  return sum;
}

void FreeSpaceTerm::linearize(const SearchPose& pose, NormalEquations& equations) const {
  const Eigen::Matrix3f R_object_frame = pose.R.transpose();
  for (std::size_t j = 0; j < count_; ++j) {
    const Ball& ball = shared_->balls[j];
    const Eigen::Vector3f arm = ball.center - pose.t;
    if (arm.squaredNorm() > ball.reach_squared) continue;
    const Eigen::Vector3f center = R_object_frame * arm;
    if (clearance_.at_least(center) >= ball.radius) continue;
    const auto sample = field_.anywhere(center);
    if (sample.distance >= ball.radius) continue;
    const Eigen::Vector3d m = (pose.R * sample.gradient).cast<double>();
    Eigen::Matrix<double, 1, 6> J;  // of the depth; moving the object away lessens it
    J << arm.cast<double>().cross(m).transpose(), m.transpose();
    const Eigen::Matrix<double, 1, 1> depth(static_cast<double>(ball.radius - sample.distance));
    equations.add(J, depth,
                  1 / static_cast<double>(variance_ + growth_variance_ * arm.squaredNorm()));
  }
}

}  // namespace palpate::localization
