// SPDX-License-Identifier: Apache-2.0
#include "palpate/registration/correspondences.hpp"

#include <fmt/format.h>

#include <cmath>

#include "palpate/core/error.hpp"
#include "registration/check_weights.hpp"

namespace palpate::registration {
namespace {

using Points = std::vector<Eigen::Vector3d>;

std::string text(const Eigen::Vector3d& p) { return fmt::format("({}, {}, {})", p[0], p[1], p[2]); }

void check_points(const Points& points, const char* name) {
  constexpr double kFarthest = 1e100;  // m; sums of squares stay finite
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (!points[i].allFinite()) {
      throw BadInput(fmt::format("{} point {} is {}, not finite", name, i, text(points[i])));
    }
    if (points[i].cwiseAbs().maxCoeff() > kFarthest) {
      throw BadInput(
          fmt::format("{} point {} is {}, farther than {} m", name, i, text(points[i]), kFarthest));
    }
  }
}

void check_normals(const Points& normals, std::size_t points, const char* name) {
  if (normals.empty()) return;
  if (normals.size() != points) {
    throw BadInput(fmt::format("{} {} normals for {} points", normals.size(), name, points));
  }
  for (std::size_t i = 0; i < normals.size(); ++i) {
    if (!(std::abs(normals[i].norm() - 1) < 1e-3)) {
      throw BadInput(
          fmt::format("{} normal {} is {}, not a unit vector", name, i, text(normals[i])));
    }
  }
}

template <class Value>
std::vector<Value> chosen(const std::vector<Value>& points, const std::vector<int>& indices) {
  std::vector<Value> result;
  if (points.empty()) return result;
  result.reserve(indices.size());
  for (const int index : indices) result.push_back(points[static_cast<std::size_t>(index)]);
  return result;
}

}  // namespace

void check_weights(const std::vector<double>& weights, std::size_t pairs) {
  if (weights.empty()) return;
  if (weights.size() != pairs) {
    throw BadInput(fmt::format("{} weights for {} correspondences", weights.size(), pairs));
  }
  for (std::size_t i = 0; i < pairs; ++i) {
    if (!(weights[i] >= 0) || !std::isfinite(weights[i])) {
      throw BadInput(fmt::format("weight {} is {}, not a number >= 0", i, weights[i]));
    }
  }
}

void check(const Correspondences& correspondences, Primitive primitive) {
  const auto& [source, target, source_normals, target_normals, weights] = correspondences;
  if (source.size() != target.size()) {
    throw BadInput(
        fmt::format("{} source points but {} target points", source.size(), target.size()));
  }
  check_points(source, "source");
  check_points(target, "target");
  check_normals(source_normals, source.size(), "source");
  check_normals(target_normals, target.size(), "target");
  check_weights(weights, source.size());
  if (primitive == Primitive::kPlane && target_normals.empty() && !target.empty()) {
    throw BadInput("the plane primitive needs target normals, but there are none");
  }
}

std::vector<double> squared_residuals(const Correspondences& correspondences,
                                      const Eigen::Isometry3d& T_target_source,
                                      Primitive primitive) {
  const Eigen::Matrix3d R = T_target_source.linear();
  const Eigen::Vector3d t = T_target_source.translation();
  std::vector<double> squared(correspondences.size());
  for (std::size_t i = 0; i < squared.size(); ++i) {
    const Eigen::Vector3d d = R * correspondences.source[i] + t - correspondences.target[i];
    if (primitive == Primitive::kPoint) {
      squared[i] = d.squaredNorm();
    } else {
      const double distance = correspondences.target_normals[i].dot(d);
      squared[i] = distance * distance;
    }
  }
  return squared;
}

Correspondences subset(const Correspondences& correspondences, const std::vector<int>& indices) {
  return {chosen(correspondences.source, indices), chosen(correspondences.target, indices),
          chosen(correspondences.source_normals, indices),
          chosen(correspondences.target_normals, indices),
          chosen(correspondences.weights, indices)};
}

Correspondences paired(const geometry::PointView& source, const geometry::PointView& target) {
  if (source.size() != target.size()) {
    throw BadInput(
        fmt::format("{} source points for {} target points", source.size(), target.size()));
  }
  geometry::PointCloud from = geometry::copied(source), to = geometry::copied(target);
  return {std::move(from.points), std::move(to.points), std::move(from.normals),
          std::move(to.normals)};
}

}  // namespace palpate::registration
