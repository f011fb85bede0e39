// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <vector>

#include "localization/search/pose_family.hpp"

namespace palpate::localization {

/// The one-parameter family through `seed` that holds the most of the poses, over the longest arc
/// without a gap; nothing when no arc spans more than a few balls of the tolerance.
std::optional<PoseFamily> fit_free_axis(const std::vector<PosePoint>& poses, const PosePoint& seed,
                                        const PoseFamily::Symmetries& symmetries);

/// The family about that of its poses near which most of its members are, where these are clearly
/// more than near its own pose; else as it is. Its arc still holds all poses that it held.
PoseFamily centered_where_densest(const PoseFamily& family, const std::vector<PosePoint>& members,
                                  const PoseFamily::Symmetries& symmetries);

/// Mean of poses near each other (rotations by the mean rotation vector).
PosePoint mean_pose(const std::vector<PosePoint>& poses);

}  // namespace palpate::localization
