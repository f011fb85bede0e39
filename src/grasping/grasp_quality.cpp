// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include "geometry/mesh/quickhull.hpp"
#include "grasping/wrench_space.hpp"
#include "palpate/core/error.hpp"
#include "palpate/grasping/force_closure.hpp"

namespace palpate::grasping {
namespace {

/// Unit directions of the load that a cone bears: along the circle of its forces, and spinning
/// either way. Few, since hulls in six dimensions have very many facets.
Eigen::MatrixXd load_directions(int size, int edges) {
  if (size == 1) return Eigen::MatrixXd(0, 1);
  std::vector<Eigen::Vector3d> directions;
  for (int i = 0; i < edges; ++i) {
    const double angle = 2 * std::numbers::pi * i / edges;
    directions.emplace_back(std::cos(angle), std::sin(angle), 0);
  }
  if (size == 4) {
    directions.emplace_back(0, 0, 1);
    directions.emplace_back(0, 0, -1);
  }
  Eigen::MatrixXd result(size - 1, static_cast<Eigen::Index>(directions.size()));
  for (std::size_t i = 0; i < directions.size(); ++i) {
    result.col(static_cast<Eigen::Index>(i)) = directions[i].head(size - 1);
  }
  return result;
}

/// Wrenches of unit normal forces along the edges of the cones (6 x k).
Eigen::MatrixXd edge_wrenches(const WrenchSpace& space, int edges) {
  std::vector<Eigen::VectorXd> points;
  Eigen::Index at = 0;
  for (const int size : space.sizes) {
    const double axis = 1 / space.normal_per_axis[at];
    const Eigen::MatrixXd directions = load_directions(size, edges);
    for (Eigen::Index i = 0; i < directions.cols(); ++i) {
      Eigen::VectorXd u(size);
      u[0] = axis;
      u.tail(size - 1) = axis * directions.col(i);
      points.emplace_back(space.wrenches.middleCols(at, size) * u);
    }
    at += size;
  }
  Eigen::MatrixXd result(6, static_cast<Eigen::Index>(points.size()));
  for (std::size_t i = 0; i < points.size(); ++i) {
    result.col(static_cast<Eigen::Index>(i)) = points[i];
  }
  return result;
}

/// Signed distance from 0 to the hull's nearest facet, positive inside; -infinity of a flat hull.
double depth_of_origin(const Eigen::MatrixXd& points) {
  const geometry::Quickhull hull(points, "Qx");
  if (hull.error() != 0) return -std::numeric_limits<double>::infinity();
  double depth = std::numeric_limits<double>::infinity();
  for (const facetT* facet = hull.facets(); facet && facet->next; facet = facet->next) {
    depth = std::min(depth, -facet->offset);
  }
  return depth;
}

}  // namespace

double grasp_quality(const GraspContacts& contacts, const Eigen::Vector3d& p_mount_object,
                     const QualityOptions& options) {
  if (options.edges < 3 || !(std::isfinite(options.length) && options.length > 0)) {
    throw BadInput(
        fmt::format("a grasp's quality needs 3 edges or more and a positive length, not "
                    "{} and {}",
                    options.edges, options.length));
  }
  if (contacts.empty()) return 0;
  const WrenchSpace space = wrench_space(contacts, p_mount_object, options.length);
  const Eigen::MatrixXd points = edge_wrenches(space, options.edges);
  const bool is_flat = points.cols() < 7 || solve_affine(points, Vector6d::Zero()).rank < 6;
  return is_flat ? 0 : std::max(0.0, depth_of_origin(points));
}

}  // namespace palpate::grasping
