// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "palpate/geometry/objects/known_object.hpp"
#include "palpate/tasks/relocate/relocate_object.hpp"

namespace palpate::relocate {

/// What the object looks like: its parts for the physics, one beside the other, in its frame,
/// m. They may overlap.
geometry::TriangleMesh surface(const RelocateObject& object);

/// Pose of the object's frame in the world, of which only the simulator knows.
/// @param positions  all generalised positions, as RelocateTask::positions gives them
Eigen::Isometry3d object_pose(const Eigen::VectorXd& positions);

/// The object as an estimator knows it; T_mesh_object leads back to the task's own frame. Where
/// parts overlap, its volume counts them twice.
/// @param mass  kg
/// @throws BadInput for a shape that a hand cannot hold
geometry::KnownObject known_object(const RelocateObject& object, double mass);

}  // namespace palpate::relocate
