// SPDX-License-Identifier: Apache-2.0
#include "palpate/tactile/sensors/height_map.hpp"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <optional>

#include "palpate/core/error.hpp"

namespace palpate::tactile {
namespace {

void check(const HeightMap& map, const HeightMapOptions& options) {
  if (map.depth.size() == 0) throw BadInput("height map: it has 0 pixels");
  if (!map.depth.allFinite()) throw BadInput("height map: a depth is not finite");
  if (!(std::isfinite(map.pixel) && map.pixel > 0)) {
    throw BadInput(fmt::format("height map: pixel is {} m, not positive", map.pixel));
  }
  const double side = map.pixel * static_cast<double>(std::max(map.depth.rows(), map.depth.cols()));
  if (map.depth.maxCoeff() > side) {
    throw BadInput(fmt::format("height map: it is {} m deep and {} m long; are both in metres?",
                               map.depth.maxCoeff(), side));
  }
  if (options.cell < 2)
    throw BadInput(fmt::format("height map: cell is {}, not > 1", options.cell));
  if (!(options.min_share > 0 && options.min_share <= 1)) {
    throw BadInput(fmt::format("height map: min_share is {}, not in 0..1", options.min_share));
  }
  const Eigen::Vector3d limits(options.min_depth, options.depth_sigma, options.slope_sigma);
  if (!limits.allFinite() || limits[0] < 0 || limits[1] <= 0 || limits[2] <= 0) {
    throw BadInput(fmt::format(
        "height map: min_depth, depth_sigma and slope_sigma are {}, {} and {}, not finite "
        "and positive",
        options.min_depth, options.depth_sigma, options.slope_sigma));
  }
}

/// Sums for the plane depth = a + b x + c y through the pixels of a square that touch.
struct PlaneFitSums {
  Eigen::Matrix3d H = Eigen::Matrix3d::Zero();
  Eigen::Vector3d g = Eigen::Vector3d::Zero();

  void add(double x, double y, double depth) {
    const Eigen::Vector3d row(1, x, y);
    H += row * row.transpose();
    g += depth * row;
  }
  double count() const { return H(0, 0); }
};

/// Pixels of the square at (row, column); x and y about the middle of the map.
PlaneFitSums gathered(const HeightMap& map, Eigen::Index row, Eigen::Index column,
                      const HeightMapOptions& options) {
  PlaneFitSums sums;
  const Eigen::Index bottom = std::min<Eigen::Index>(row + options.cell, map.depth.rows());
  const Eigen::Index right = std::min<Eigen::Index>(column + options.cell, map.depth.cols());
  for (Eigen::Index i = row; i < bottom; ++i) {
    for (Eigen::Index j = column; j < right; ++j) {
      if (!(map.depth(i, j) > options.min_depth)) continue;
      const double x = static_cast<double>(2 * j + 1 - map.depth.cols()) / 2 * map.pixel;
      const double y = static_cast<double>(2 * i + 1 - map.depth.rows()) / 2 * map.pixel;
      sums.add(x, y, map.depth(i, j));
    }
  }
  return sums;
}

/// Nothing for pixels on one line, which have no slope.
std::optional<Contact> contact_of(const PlaneFitSums& sums, const HeightMap& map,
                                  const HeightMapOptions& options) {
  const double x = sums.H(0, 1) / sums.count(), y = sums.H(0, 2) / sums.count();
  Eigen::Matrix2d spread = sums.H.bottomRightCorner<2, 2>() / sums.count();
  spread -= Eigen::Vector2d(x, y) * Eigen::RowVector2d(x, y);
  if (!(spread.determinant() > 1e-3 * std::pow(map.pixel, 4.0))) return std::nullopt;
  const Eigen::Vector3d plane = sums.H.ldlt().solve(sums.g);
  Contact contact;
  contact.p = {x, y, -(plane[0] + plane[1] * x + plane[2] * y)};
  contact.n = -Eigen::Vector3d(plane[1], plane[2], 1).normalized();
  contact.point_sigma = options.depth_sigma;
  const double lever = std::sqrt(spread.selfadjointView<Eigen::Lower>().eigenvalues()[0]);
  contact.normal_sigma = std::hypot(options.slope_sigma, options.depth_sigma / lever);
  return contact;
}

}  // namespace

std::vector<Contact> contacts_of_height_map(const HeightMap& map,
                                            const Eigen::Isometry3d& T_frame_sensor,
                                            const HeightMapOptions& options) {
  check(map, options);
  const double least = options.min_share * options.cell * options.cell;
  std::vector<Contact> contacts;
  for (Eigen::Index row = 0; row < map.depth.rows(); row += options.cell) {
    for (Eigen::Index column = 0; column < map.depth.cols(); column += options.cell) {
      const PlaneFitSums sums = gathered(map, row, column, options);
      if (sums.count() < least) continue;
      auto contact = contact_of(sums, map, options);
      if (!contact) continue;
      contact->p = T_frame_sensor * contact->p;
      contact->n = T_frame_sensor.linear() * contact->n;
      contacts.push_back(*contact);
    }
  }
  return contacts;
}

}  // namespace palpate::tactile
