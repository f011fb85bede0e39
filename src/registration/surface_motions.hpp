// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "palpate/geometry/cloud/point_cloud.hpp"
#include "palpate/registration/free_motions.hpp"

namespace palpate::registration {

/// Motions that slide a surface along itself: those whose twist moves no point along its normal,
/// within what the noise of the normals does.
///
/// Of noise s rad an axis a free motion gets a share of about s^2 of the information that one unit
/// residual a point gives; s is taken from how normals differ from the mean of their neighbours'.
/// @param cloud  with normals, of either sign; evenly sampled, as by voxel_sampled()
std::vector<FreeMotion> free_surface_motions(const geometry::PointCloud& cloud);

/// The noise s, rad: median over the points.
double normal_noise(const geometry::PointCloud& cloud);

/// Shares of the information, ascending, that the six motions about the centroid have.
Vector6d motion_shares(const geometry::PointCloud& cloud);

}  // namespace palpate::registration
