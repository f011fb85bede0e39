// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <vector>

#include "palpate/registration/cloud_registration.hpp"

namespace palpate::registration {

/// Poses that a nearly symmetric source may be mistaken for when it lies at `T`: turned about each
/// of its principal axes, through its mean and through the middle of its box.
/// @param steps  of a full turn; 2: half turns
std::vector<Eigen::Isometry3d> turned_about_axes(const geometry::PointCloud& source,
                                                 const Eigen::Isometry3d& T, int steps);

/// Poses at which the principal axes of both clouds lie on one another, through their means or the
/// middles of their boxes. If both are of all of one object, the right pose is near one of them.
std::vector<Eigen::Isometry3d> with_axes_aligned(const geometry::PointCloud& source,
                                                 const geometry::PointCloud& target);

/// Reflections that a mirrored source may be when it was put at `T`: it, mirrored in each of its
/// principal planes, through its mean and through the middle of its box. Their linear parts have
/// determinant -1.
std::vector<Eigen::Isometry3d> reflected(const geometry::PointCloud& source,
                                         const Eigen::Isometry3d& T);

/// Poses of a source that is nearly its own mirror image in one of its principal planes, where that
/// mirror image (mirror_image()) lies at `T_mirrored`.
std::vector<Eigen::Isometry3d> unmirrored(const geometry::PointCloud& source,
                                          const Eigen::Isometry3d& T_mirrored);

struct BetterFit {
  Eigen::Isometry3d T_target_source;
  double deviations;  ///< how much better, in standard errors of the points' paired differences
};

/// Those of other poses at which more of the source's points lie near the target than at T, of a
/// few hundred: by 2 % within the bound, or within three of them, as where a pose is not refined
/// yet. The rest need no closer look where T is clear.
/// @param others  poses or reflections
/// @return nothing where more than a twentieth of the source lies farther from the target than
/// three
///         bounds at T, so that T is not clear
std::optional<std::vector<Eigen::Isometry3d>> promising(
    const geometry::PointCloud& source, const geometry::PointCloud& target,
    const Eigen::Isometry3d& T, const std::vector<Eigen::Isometry3d>& others, double noise_bound,
    const CloudOptions& options);

/// The one of several poses, each after some rounds of nearest neighbours with a thousand points,
/// at which the clouds fit best: by the truncated cost of points of both clouds.
/// @param source, target  with normals, of either sign
/// @param T  the pose to beat; or none
/// @return nothing if none is better by a standard error
std::optional<BetterFit> better_fitting(const geometry::PointCloud& source,
                                        const geometry::PointCloud& target,
                                        const std::optional<Eigen::Isometry3d>& T,
                                        const std::vector<Eigen::Isometry3d>& others,
                                        double noise_bound, const CloudOptions& options);

}  // namespace palpate::registration
