// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "palpate/geometry/mesh/mesh.hpp"
#include "palpate/geometry/objects/known_object.hpp"

namespace palpate::geometry {

struct StablePoseOptions {
  /// A stable pose left by raising the centroid by less than this (m) is none: the object rolls on.
  /// It also joins the facets of a finely tessellated curved side into one family of stable poses.
  double barrier = 1e-4;
  double merge_angle_deg = 4;     ///< stable poses whose up vectors are closer than this are one
  double min_probability = 0.01;  ///< rarer families of stable poses are left out
  int max_stable_poses = 24;      ///< a family of many keeps members spread evenly
};

/// The ways a rigid body rests on a plane, with their probability when dropped at random without
/// momentum; most probable first, the probabilities sum to 1.
///
/// A random drop lands on a facet of the convex hull in proportion to the solid angle that the
/// facet fills as seen from the centroid, and rolls over the edge that the centroid overhangs most,
/// until it overhangs none (Goldberg, Mirtich, Zhuang, Craig, Carlisle & Canny 1999).
/// The table's frame has z up. Yaw: the object's x axis, or y where x is nearly upright, projects
/// onto +x.
/// @param centroid  of the volume, in the mesh's frame, m
/// @throws BadInput for a mesh that spans no volume or an option out of range
std::vector<StablePose> stable_poses(const TriangleMesh& mesh, const Eigen::Vector3d& centroid,
                                     const StablePoseOptions& options = {});

}  // namespace palpate::geometry
