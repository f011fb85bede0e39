// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "localization/search/pose_family.hpp"

namespace palpate::localization {

/// Summary of equally weighted poses as at most `most` modes, heaviest first: greedily the ball (5
/// deg, 10 mm) or free axis that holds the most of what is left. They end where they hold all but a
/// few, scattered poses.
///
/// The modes are chosen on one population and weighed on another, independent one: a weight
/// measured where it was the largest is too large. Where the two disagree on the order of modes,
/// these share their weight (isotonic regression by pooling adjacent violators). Where it is like
/// none of the second, the one mode that is left weighs half a pose: what was found is not
/// excluded.
std::vector<Mode> find_modes(const std::vector<PosePoint>& chosen_on,
                             const std::vector<PosePoint>& weighed_on,
                             const PoseFamily::Symmetries& symmetries, std::size_t most);

}  // namespace palpate::localization
