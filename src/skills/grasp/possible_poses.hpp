// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "palpate/grasping/grasp_plan.hpp"
#include "palpate/localization/posterior.hpp"

namespace palpate::skills {

/// The poses that a grasp is planned for: the best one first, and unless that is nearly certain the
/// heaviest of the others, twelve in all.
/// @param resting  in the world, with one mode or more
std::vector<grasping::PossiblePose> possible_poses(const localization::Posterior& resting);

}  // namespace palpate::skills
