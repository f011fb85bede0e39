// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "palpate/recording/recording.hpp"
#include "palpate/tasks/relocate/rollout.hpp"

namespace palpate::relocate {

/// Runs episode `index` of a seed and records it, for people to look at: the hand as the Shadow
/// hand that the Adroit hand models, the object's parts, the target, and what the episode went
/// through (reach, carry, hold). Nothing is sensed in it: torques, forces and contacts are empty.
/// A frame's command holds the joints and the base that were reached, not the policy's action,
/// which the Shadow hand has no command for.
/// @throws BadInput if the task or the drawn hand cannot be used
recording::Recording record_episode(const TaskOptions& task, const Policy& policy,
                                    const EpisodeOptions& episode, std::uint64_t seed,
                                    std::size_t index);

}  // namespace palpate::relocate
