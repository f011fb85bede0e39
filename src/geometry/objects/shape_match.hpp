// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "geometry/objects/symmetry.hpp"
#include "palpate/geometry/query/distance_field.hpp"
#include "palpate/geometry/query/mesh_query.hpp"

namespace palpate::geometry {

/// How well a shape, rotated about the origin, matches itself.
class ShapeMatch {
 public:
  /// @param mesh  with its centroid at the origin
  ShapeMatch(const TriangleMesh& mesh, const SymmetryTolerance& tolerance);

  /// Mean distance of the rotated shape from the shape on a coarse distance field, m: quick.
  double screen(const Eigen::Matrix3d& R) const;

  /// The rotation near R of least squared distance, on the coarse field.
  Eigen::Matrix3d refine_coarsely(const Eigen::Matrix3d& R) const;

  /// The rotation near R of least squared distance, on the surface itself.
  Eigen::Matrix3d refine(const Eigen::Matrix3d& R) const;

  /// Whether the rotated shape lies within the tolerance of the shape.
  bool accepts(const Eigen::Matrix3d& R) const { return accept({R}); }

  /// Whether the shapes rotated by each lie within the tolerance of the shape, taken together: a
  /// dent shows in some turns about an axis more than in others.
  bool accept(const std::vector<Eigen::Matrix3d>& rotations) const;

 private:
  struct Distances {
    double mean, quantile_95, quantile_997;  // m
  };
  Distances distances(const std::vector<Eigen::Vector3d>& points,
                      const std::vector<Eigen::Matrix3d>& rotations) const;

  SymmetryTolerance tolerance_;  // scaled to the object's radius
  MeshQuery query_;
  DistanceField field_;
  std::vector<Eigen::Vector3d> few_points_, points_;
};

}  // namespace palpate::geometry
