// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "palpate/geometry/mesh/mesh.hpp"

namespace palpate::geometry {

struct MassProperties {
  double volume = 0;                                   ///< m^3
  Eigen::Vector3d centroid = Eigen::Vector3d::Zero();  ///< of the volume, m
  Eigen::Matrix3d inertia = Eigen::Matrix3d::Zero();   ///< about the centroid, kg m^2
};

/// Volume, centroid and inertia of a watertight mesh of uniform density and the given mass (kg).
/// Integrals over signed tetrahedra (Blow & Binstock 2004).
/// @throws BadInput unless the volume is positive
MassProperties mass_properties(const TriangleMesh& mesh, double mass);

}  // namespace palpate::geometry
