// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "palpate/geometry/mesh/mesh.hpp"

namespace palpate::geometry {

/// How far a rotated surface may lie from the original for the rotation to keep the shape, m.
/// The quantile near 1 is what distinguishes a mug from a beaker: its handle is 4 % of the surface.
struct SymmetryTolerance {
  double mean = 1.0e-3;
  double quantile_95 = 2.1e-3;
  double quantile_997 = 4.0e-3;
  double full_radius = 0.045;  ///< for objects of a smaller radius all three shrink in proportion
};

/// Rotations about `centroid` that keep the shape, identity first; together a group.
///
/// Found from the surface: a deterministic covering of SO(3) and the principal axes are screened on
/// a coarse distance field, the best are refined locally, and those within tolerance on the exact
/// surface are pruned to a set closed under products and averaged until it is exactly a group.
/// A shape of revolution is given by a rotation every 2 degrees about its axis, and the flips if it
/// has them; a ball by a covering of SO(3) to about 10 degrees.
/// @param centroid  of the volume, in the mesh's frame, m
/// @throws BadInput for a mesh without area or a tolerance that is not positive
std::vector<Eigen::Matrix3d> rotational_symmetries(const TriangleMesh& mesh,
                                                   const Eigen::Vector3d& centroid,
                                                   const SymmetryTolerance& tolerance = {});

}  // namespace palpate::geometry
