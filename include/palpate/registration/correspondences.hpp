// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Geometry>
#include <vector>

#include "palpate/geometry/cloud/point_cloud.hpp"

namespace palpate::registration {

/// Pairs of points thought to be the same point of an object, seen in two frames.
struct Correspondences {
  std::vector<Eigen::Vector3d> source, target;                  ///< m, equally many
  std::vector<Eigen::Vector3d> source_normals, target_normals;  ///< unit; empty, or one a point

  /// How much each pair is to be trusted, >= 0: those of more are looked at first and count more in
  /// the last solve, those of 0 not at all. Empty: all alike.
  std::vector<double> weights = {};

  std::size_t size() const { return source.size(); }
  bool has_normals() const { return !source_normals.empty() && !target_normals.empty(); }
};

/// Pairs of the points, and of the normals where there are any, of two views of as many points,
/// read once: the search works on columns of its own.
/// @throws BadInput for views of different sizes
Correspondences paired(const geometry::PointView& source, const geometry::PointView& target);

/// What a source point is held against.
enum class Primitive {
  kPoint,  ///< the target point, thesis eq. 6.5
  kPlane,  ///< the plane through the target point along its normal, thesis eq. 6.6
};

/// @throws BadInput, naming the pair, for lists of different lengths, a coordinate that is not
///         finite, a normal that is not of unit length to 1e-3, a weight below 0, or planes without
///         target normals
void check(const Correspondences& correspondences, Primitive primitive = Primitive::kPoint);

/// Squared distance of every moved source point to its primitive, m^2 (thesis eqs 6.5 and 6.6).
std::vector<double> squared_residuals(const Correspondences& correspondences,
                                      const Eigen::Isometry3d& T_target_source,
                                      Primitive primitive);

/// The pairs that `indices` names, in that order.
Correspondences subset(const Correspondences& correspondences, const std::vector<int>& indices);

}  // namespace palpate::registration
