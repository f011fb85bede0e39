// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "palpate/registration/cloud_registration.hpp"

namespace palpate::registration {

/// The points that are at most a thousand times as far out as half of them are; nothing if those
/// are all. One far point would make every grid too coarse.
std::optional<geometry::PointCloud> without_far_points(const geometry::PointView& cloud);

/// The cloud itself, or so many of its points that nearest neighbours are found soon.
geometry::PointCloud thinned(const geometry::PointView& cloud);

/// Normals of either sign, for a cloud of three points or more without.
void add_normals(geometry::PointCloud& cloud, const FeatureOptions& options, int threads);

class NeighbourRounds;

/// The pose at which nearest neighbours and pose in turn end up from T, within some rounds at one
/// bound; nothing where too few have a neighbour.
std::optional<Eigen::Isometry3d> settled(NeighbourRounds& rounds, const Eigen::Isometry3d& T,
                                         double bound, int most);

/// How far above 0 the mean of costs - others is, in standard errors. Neighbours, whose normals
/// were fitted to the same points, count together.
double standard_errors(const std::vector<double>& costs, const std::vector<double>& others,
                       int neighbours);

/// Nearest neighbours and pose in turn from the result's pose, until the pose stays, then with half
/// and a quarter of the bound; the result then speaks of them. A pose at which too few points have
/// a neighbour, or their residuals look like chance, is refused.
/// @param source, target  with normals, of either sign
void refine_clouds(const geometry::PointCloud& source, const geometry::PointCloud& target,
                   const CloudOptions& options, CloudRegistration& registration);

/// The points (and normals) with x turned round.
geometry::PointCloud mirror_image(geometry::PointCloud cloud);

/// Refuses the result as `mirrored` if the source's mirror image, refined from T_mirrored or from a
/// half turn there that fits better, fits the target better than the source at the result's pose
/// (or any, without one): if the truncated cost of its points, at a quarter of the bound, is less
/// by three standard errors of their paired differences.
/// @param T_without  what stands for the source's own pose where the result has none
void refuse_if_mirrored(const geometry::PointCloud& source, const geometry::PointCloud& target,
                        const Eigen::Isometry3d& T_mirrored,
                        const std::optional<Eigen::Isometry3d>& T_without,
                        const CloudOptions& options, CloudRegistration& registration);

}  // namespace palpate::registration
