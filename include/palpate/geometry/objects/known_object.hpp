// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "palpate/geometry/mesh/mass_properties.hpp"
#include "palpate/geometry/mesh/mesh.hpp"

namespace palpate::geometry {

/// A way the object rests on a plane: R_table_object up to yaw, and its share of random drops.
struct StablePose {
  Eigen::Matrix3d R_table_object;
  double height = 0;       ///< z of the volume centroid above the table, m
  double probability = 0;  ///< all stable poses of an object sum to 1
};

/// An object of known shape. The object's frame is that of its mesh, moved so that the volume
/// centroid is the origin; `T_mesh_object` maps back to the file's own coordinates.
struct KnownObject {
  std::string name;
  TriangleMesh mesh;  ///< watertight, in the object's frame
  Eigen::Isometry3d T_mesh_object = Eigen::Isometry3d::Identity();
  double mass = 0;                          ///< kg
  MassProperties mass_properties;           ///< at `mass`, of uniform density
  std::vector<StablePose> stable_poses;     ///< most probable first
  std::vector<Eigen::Matrix3d> symmetries;  ///< rotations that keep the shape, identity first
  std::vector<std::string> repairs;         ///< what was done to the file's mesh, in words
  double size = 1;                          ///< relative to the mesh that it was made of
};

/// m above the table of its highest point in a stable pose.
double top_of(const KnownObject& object, const StablePose& stable_pose);

/// A name and the size after its @: `mug@0.95`.
struct SizedName {
  std::string name;
  double size = 1;
};

/// A name that is a file's, or has no number after an @, stays whole.
/// @throws BadInput for a size that is not 0.1 to 10
SizedName sized_name(const std::string& name);

/// A built-in object (mug, bottle, box, bracket, duck), `generated:SEED`, a mesh file in metres, or
/// `bunny`, the Stanford bunny, where it is installed (it is not for commercial use); of another
/// size where its name ends with it, as sized_name() reads it.
///
/// @throws BadInput for an unknown name, or a mesh that cannot be read, repaired, or that is
///         smaller than 10 mm or larger than 400 mm (one in millimetres is named as such)
KnownObject load_known_object(const std::string& name_or_file);

/// An object of that shape (m).
/// @param mass  kg; 0: from the volume
/// @throws BadInput as load_known_object, naming the object
KnownObject make_known_object(const std::string& name, const TriangleMesh& mesh, double mass);

/// The same shape in another size: its mesh, about the origin of the file's own coordinates, times
/// `factor`, its mass times the cube of that.
/// @throws BadInput as load_known_object, naming the object
KnownObject resized(KnownObject object, double factor);

/// Whether two objects are the same shape, of the same or another size.
bool is_same_shape(const KnownObject& a, const KnownObject& b);

/// Names of the built-in objects.
const std::vector<std::string>& built_in_objects();

}  // namespace palpate::geometry
