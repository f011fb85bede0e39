// SPDX-License-Identifier: Apache-2.0
#include "geometry/objects/shape_match.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "palpate/core/random.hpp"
#include "palpate/core/se3.hpp"
#include "palpate/geometry/mesh/sampling.hpp"

namespace palpate::geometry {
namespace {

constexpr std::size_t kFew = 200, kMany = 2000;
constexpr double kFieldCells = 32;  // over the longest side

double field_cell(const TriangleMesh& mesh) {
  return bounds(mesh).sizes().maxCoeff() / kFieldCells;
}

std::vector<Eigen::Vector3d> surface_points(const TriangleMesh& mesh, std::size_t count) {
  std::vector<Eigen::Vector3d> points;
  for (const SurfaceSample& sample : sample_surface(mesh, count, RandomStream(0, "symmetry"))) {
    points.push_back(sample.point);
  }
  return points;
}

SymmetryTolerance scaled(SymmetryTolerance tolerance, const TriangleMesh& mesh) {
  double radius = 0;
  for (const Eigen::Vector3d& v : mesh.vertices) radius = std::max(radius, v.norm());
  const double scale = std::min(1.0, radius / tolerance.full_radius);
  tolerance.mean *= scale;
  tolerance.quantile_95 *= scale;
  tolerance.quantile_997 *= scale;
  return tolerance;
}

/// Gauss-Newton on the squared distances of rotated points; `nearest` gives a point's signed
/// distance along an outward direction, or nothing for a point to leave out.
template <typename Nearest>
Eigen::Matrix3d rotate_onto(const std::vector<Eigen::Vector3d>& points, Eigen::Matrix3d R,
                            int iterations, const Nearest& nearest) {
  for (int i = 0; i < iterations; ++i) {
    Eigen::Matrix3d H = 1e-12 * Eigen::Matrix3d::Identity();  // m^2: below any point's share
    Eigen::Vector3d g = Eigen::Vector3d::Zero();
    for (const Eigen::Vector3d& p : points) {
      const Eigen::Vector3d moved = R * p;
      Eigen::Vector3d direction;
      double distance = 0;
      if (!nearest(moved, direction, distance)) continue;
      const Eigen::Vector3d J = moved.cross(direction);
      H += J * J.transpose();
      g += J * distance;
    }
    constexpr double kLongestStep = 0.2;  // rad
    Eigen::Vector3d step = -H.ldlt().solve(g);
    if (step.norm() > kLongestStep) step *= kLongestStep / step.norm();
    R = exp_so3(step) * R;
  }
  return R;
}

}  // namespace

ShapeMatch::ShapeMatch(const TriangleMesh& mesh, const SymmetryTolerance& tolerance)
    : tolerance_(scaled(tolerance, mesh)),
      query_(mesh),
      field_(query_, field_cell(mesh), 4 * field_cell(mesh)),
      few_points_(surface_points(mesh, kFew)),
      points_(surface_points(mesh, kMany)) {}

double ShapeMatch::screen(const Eigen::Matrix3d& R) const {
  const Eigen::Matrix3f R_float = R.cast<float>();
  double sum = 0;
  for (const Eigen::Vector3d& p : few_points_) {
    sum += std::abs(field_.distance(R_float * p.cast<float>()));
  }
  return sum / static_cast<double>(few_points_.size());
}

Eigen::Matrix3d ShapeMatch::refine_coarsely(const Eigen::Matrix3d& R) const {
  return rotate_onto(few_points_, R, 12,
                     [&](const Eigen::Vector3d& p, Eigen::Vector3d& direction, double& distance) {
                       const auto sample = field_.at(p.cast<float>());
                       if (!sample) return false;
                       direction = sample->gradient.cast<double>();
                       distance = sample->distance;
                       return true;
                     });
}

Eigen::Matrix3d ShapeMatch::refine(const Eigen::Matrix3d& R) const {
  return rotate_onto(few_points_, R, 4,
                     [&](const Eigen::Vector3d& p, Eigen::Vector3d& direction, double& distance) {
                       const ClosestPoint closest = query_.closest_point(p);
                       direction = closest.normal;
                       distance = closest.normal.dot(p - closest.point);
                       return true;
                     });
}

ShapeMatch::Distances ShapeMatch::distances(const std::vector<Eigen::Vector3d>& points,
                                            const std::vector<Eigen::Matrix3d>& rotations) const {
  std::vector<double> sorted;
  sorted.reserve(points.size() * rotations.size());
  for (const Eigen::Matrix3d& R : rotations) {
    for (const Eigen::Vector3d& p : points) sorted.push_back(query_.closest_point(R * p).distance);
  }
  std::ranges::sort(sorted);
  const double last = static_cast<double>(sorted.size() - 1);
  const auto quantile = [&](double q) { return sorted[static_cast<std::size_t>(q * last)]; };
  const double sum = std::accumulate(sorted.begin(), sorted.end(), 0.0);
  return {sum / static_cast<double>(sorted.size()), quantile(0.95), quantile(0.997)};
}

bool ShapeMatch::accept(const std::vector<Eigen::Matrix3d>& rotations) const {
  if (distances(few_points_, rotations).mean > 2 * tolerance_.mean) return false;  // saves time
  const Distances all = distances(points_, rotations);
  return all.mean < tolerance_.mean && all.quantile_95 < tolerance_.quantile_95 &&
         all.quantile_997 < tolerance_.quantile_997;
}

}  // namespace palpate::geometry
