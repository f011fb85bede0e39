// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "palpate/geometry/objects/known_object.hpp"

namespace palpate::skills {

/// Pose of the object at rest: its centroid over x, y; yaw as stable_poses() counts it.
Eigen::Isometry3d resting_pose(const geometry::KnownObject& object, std::size_t stable_pose,
                               const Eigen::Vector2d& xy, double yaw);

}  // namespace palpate::skills
