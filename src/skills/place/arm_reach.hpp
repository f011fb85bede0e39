// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "palpate/skills/executor.hpp"
#include "palpate/skills/place/place_goal.hpp"

namespace palpate::skills {

/// Why what carries the hand cannot bring it over a goal and down to it; empty: it can, on straight
/// lines or, with an arm, in any posture from which it can come down.
std::string arm_obstacle(const Executor& robot, const PlaceGoal& goal);

/// Whether the mount can be brought there from above, with any of the yaws that make its pose.
/// @param rise  m over the place, from which the hand comes down
bool releases(const Executor& robot, const hand::MountPosition& mount, double rise);

}  // namespace palpate::skills
