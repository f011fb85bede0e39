// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <vector>

#include "palpate/geometry/cloud/point_cloud.hpp"
#include "palpate/registration/correspondences.hpp"
#include "palpate/registration/free_motions.hpp"
#include "palpate/registration/pose.hpp"

namespace palpate::registration {

/// Motions that slide a surface along itself: those whose twist moves no point along its normal,
/// within what chance does.
///
/// Two estimates of the normal at a point, of independent noise, give two estimates r, s of how far
/// a unit twist x moves it along the normal. The mean of (r . x) (s . x) is free of the noise,
/// which the mean square of either is not, and where a motion is free it is as often negative as
/// not: the negative products estimate its standard error.
/// @param turns  motions by others are not allowed, and not free
/// @param cloud  evenly sampled; its own normals are not used. The estimates are plane fits to each
///        half of the points
std::vector<FreeMotion> free_surface_motions(const geometry::PointCloud& cloud,
                                             const AllowedTurns& turns = {});

/// The same of the part of the target's surface that correspondences cover, whose two estimates are
/// the target's normals and the moved source's, of either sign.
std::vector<FreeMotion> free_motions_of_overlap(const Correspondences& pairs,
                                                const Eigen::Isometry3d& T_target_source,
                                                const AllowedTurns& turns = {});

/// The axis that the overlap is nearly round about: the motion that gets the least of the
/// information, if that is a rotation and gets less than a fiftieth of what a unit residual a
/// point gives.
std::optional<FreeMotion> weak_rotation(const Correspondences& pairs,
                                        const Eigen::Isometry3d& T_target_source,
                                        const AllowedTurns& turns = {});

}  // namespace palpate::registration
