// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Geometry>

#include "palpate/geometry/mesh.hpp"

namespace palpate::pipeline {

/// Where a hand that comes from above should close, and how it should be turned.
struct GraspAim {
  Eigen::Vector2d place;  ///< middle between the jaws, world, m
  double yaw = 0;         ///< rad
};

/// Turns the hand so that thumb and fingers close on the object's narrowest side.
///
/// @param T_world_object  pose of the resting object
/// @param closing_angle  direction from the thumb to the fingers, from the hand's x axis, rad
GraspAim aim_from_above(const geometry::TriangleMesh& mesh, const Eigen::Isometry3d& T_world_object,
                        double closing_angle);

}  // namespace palpate::pipeline
