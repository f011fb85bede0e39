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
  constexpr float kNever = -1;
  fours.resize((balls.size() + 3) / 4, FourBalls{{}, {}, Floats4{} + kNever});
  for (std::size_t j = 0; j < balls.size(); ++j) {
    FourBalls& four = fours[j / 4];
    const auto lane = static_cast<int>(j % 4);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      four.center[axis][lane] = balls[j].center[static_cast<Eigen::Index>(axis)];
    }
    four.radius[lane] = balls[j].radius;
    four.reach_squared[lane] = balls[j].reach_squared;
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

void FreeSpaceTerm::place(const SearchPose& pose, std::size_t first, Batch& batch) const {
  const Eigen::Matrix3f& R = pose.R;
  const Eigen::Vector3f& t = pose.t;
  const std::size_t size = std::min(Batch::kSize, count_ - first);
  std::size_t near_count = 0;
  for (std::size_t i = 0; i < size; i += 4) {
    const FourBalls& four = shared_->fours[(first + i) / 4];
    const Floats4 x = four.center[0] - t[0], y = four.center[1] - t[1], z = four.center[2] - t[2];
    const auto along = [&](int axis) { return R(0, axis) * x + (R(1, axis) * y + R(2, axis) * z); };
    batch.x[i / 4] = along(0);
    batch.y[i / 4] = along(1);
    batch.z[i / 4] = along(2);
    batch.arm_squared[i / 4] = x * x + (y * y + z * z);
    const Ints4 far = batch.arm_squared[i / 4] > four.reach_squared;
    const Ints4 places = clearance_.places_of(batch.x[i / 4], batch.y[i / 4], batch.z[i / 4], ~far);
    for (std::size_t lane = 0; lane < 4; ++lane) {  // without a branch, which is hard to predict
      const float clear = clearance_.value_at(places[static_cast<int>(lane)]);
      batch.near[near_count] = i + lane;
      near_count += !(clear >= four.radius[static_cast<int>(lane)]) && i + lane < size;
    }
  }
  batch.near_count = near_count;
}

float FreeSpaceTerm::distance_at(const Eigen::Vector3f& center,
                                 const geometry::DistanceField::Cell& cell) const {
  const float distance = cell.node ? field_.distance(cell) : field_.beyond();
  return distance < field_.beyond() ? distance : field_.anywhere(center).distance;
}

float FreeSpaceTerm::energy(const SearchPose& pose, float bound) const {
  Batch batch;
  std::array<geometry::DistanceField::Cell, Batch::kSize> cells;
  float sum = 0;
  for (std::size_t first = 0; first < count_; first += Batch::kSize) {
    place(pose, first, batch);
    for (std::size_t n = 0; n < batch.near_count; ++n) {
      cells[n] = field_.fetched(batch.center(batch.near[n]));
    }
    for (std::size_t n = 0; n < batch.near_count; ++n) {
      const std::size_t i = batch.near[n];
      const float depth = shared_->balls[first + i].radius - distance_at(batch.center(i), cells[n]);
      if (depth <= 0) continue;
      sum +=
          0.5F * depth * depth / (variance_ + growth_variance_ * Batch::of(batch.arm_squared, i));
      if (sum > bound) return sum;
    }
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
