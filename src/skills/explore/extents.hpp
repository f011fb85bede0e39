// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "palpate/estimation/estimate.hpp"
#include "palpate/localization/information/guarded_move_choice.hpp"

namespace palpate::skills {

/// m above the table of the highest point that any candidate has in any stable pose.
double tallest(const estimation::Candidates& candidates);

/// m above the table at which the hand travels over any candidate, however it stands.
double clear_height_over(const estimation::Candidates& candidates);

/// As tallest() in those stable poses that may be as tall as was `measured` (m): that may be a
/// little too high, or much too low, for a flat hand comes down beside what is highest. At least
/// `measured`.
double likely_top(const estimation::Candidates& candidates, double measured);

/// m over the table from an object's center to its farthest point, in the stable poses that are as
/// tall as was measured or taller; in all of them where none is.
double likely_reach(const estimation::Candidates& candidates, double measured);

/// All candidates at their poses by the last estimate.
std::vector<localization::PosedObject> possible_objects(const estimation::PoseEstimator& estimator);

/// Share of the posterior, over all objects, that is in none of the modes.
double mass_elsewhere(const std::vector<localization::PosedObject>& objects);

/// m above the table of the highest point of objects at any of their poses.
double highest_of(const std::vector<localization::PosedObject>& objects);

}  // namespace palpate::skills
