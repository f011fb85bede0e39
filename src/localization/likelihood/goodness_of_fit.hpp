// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "localization/likelihood/search_pose.hpp"
#include "palpate/localization/localizer.hpp"

namespace palpate::localization {

/// Whether even the best pose does not explain the contacts: more of them are false there than
/// false_contact_share lets expect, or they all miss the surface by far more than their noise.
bool fit_is_rejected(const geometry::ObjectModel& model, const Evidence& evidence,
                     const SearchPose& best, double contact_offset);

/// What the modes, heaviest first, amount to.
PoseStatus status_of(const std::vector<Mode>& modes);

}  // namespace palpate::localization
