// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Geometry>
#include <string>
#include <vector>

#include "palpate/geometry/mesh/mesh.hpp"

namespace palpate::relocate {

/// A solid that collision is cheap for, in the object's frame.
struct RelocatePrimitive {
  enum class Shape { box, cylinder };  ///< a cylinder's axis is its z
  Shape shape = Shape::box;
  Eigen::Vector3d half =
      Eigen::Vector3d::Zero();  ///< half sizes; radius, half height for cylinders
  Eigen::Isometry3d T_object_part = Eigen::Isometry3d::Identity();
};

/// What is relocated: its shape for the physics, its inertia, and how it starts on the table.
///
/// The inertia is explicit because what a compiler makes of overlapping parts depends on its
/// version.
struct RelocateObject {
  std::string name;
  std::vector<RelocatePrimitive> primitives;
  std::vector<geometry::TriangleMesh> hulls;          ///< convex parts, m
  double mass = 0;                                    ///< kg
  Eigen::Vector3d center = Eigen::Vector3d::Zero();   ///< of mass, m
  Eigen::Matrix3d inertia = Eigen::Matrix3d::Zero();  ///< about it, in the frame's axes, kg m^2
  double start_height = 0;                            ///< of the frame above the table, m
  Eigen::Quaterniond start_rotation = Eigen::Quaterniond::Identity();
};

/// The mug of 16 primitives: 12 boxes around, a floor, and a handle of 3 boxes. Modelled on the YCB
/// mug at scale 0.8.
RelocateObject relocate_primitive_mug();

/// The YCB mug at scale 0.8 as convex parts of its mesh.
/// @param mesh  of the YCB object set's 025_mug, as it comes, m
RelocateObject relocate_ycb_mug(const geometry::TriangleMesh& mesh);

/// The same object in another size: the mass stays, the inertia goes with the square.
/// @throws BadInput for a scale that is not positive
RelocateObject scaled(RelocateObject object, double scale);

/// Any watertight mesh (m) of uniform density as convex parts, its start as the mesh stands,
/// upright along +z, on its lowest point. The frame's origin is the volume centroid.
/// @throws BadInput for a mesh without volume, or a mass that is not positive
RelocateObject relocate_mesh_object(const std::string& name, const geometry::TriangleMesh& mesh,
                                    double mass);

}  // namespace palpate::relocate
