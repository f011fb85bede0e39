// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "palpate/estimation/estimate.hpp"
#include "palpate/localization/localizer.hpp"
#include "palpate/skills/executor.hpp"
#include "skills/probe/probe_choice.hpp"

namespace palpate::skills {

/// A turn of the object between the fingers, on which the fingertips roll to other spots of it.
struct Roll {
  Eigen::Vector3d turn = Eigen::Vector3d::Zero();  ///< rotation vector, base's axes, rad
  ExpectedGain expected_gain;
};

/// The turn about one of the base's axes from which most is to be learnt about which of the poses
/// in question is true. A fingertip that does not turn along rolls by its radius times the turn
/// over the object's surface; what differs between the poses is how far it then is from the
/// surface, and the normal there.
///
/// @param held      the object's pose in the world
/// @param contacts  of the fingertips, base's frame
/// @return nothing where fewer than the thumb and three fingers touch: rolled, it might fall
std::optional<Roll> most_informative_roll(const Executor& robot,
                                          const geometry::ObjectModel& object,
                                          const localization::Posterior& held,
                                          const std::vector<tactile::Contact>& contacts);

/// Rolls the object there, marks `rolled`, and rolls it back.
/// @return whether the fingers touch it where they did; else it has slipped, who knows how far
bool roll(Executor& robot, const geometry::ObjectModel& object, const localization::Posterior& held,
          const Roll& roll, const tactile::ContactErrorModel& errors, std::uint64_t seed);

}  // namespace palpate::skills
