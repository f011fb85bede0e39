// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "palpate/learning/rollout.hpp"
#include "palpate/recording/recording.hpp"

namespace palpate::learning {

/// Joints of the Shadow hand that hold it as the Adroit hand is held at these positions: the latter
/// models the former, with the joints in another order and the axes of some turned round.
/// @param joints  base, wrist and fingers of the Adroit hand; the base is not looked at
hand::JointVector shadow_joints(const simulation::RelocateJoints& joints);

/// Runs episode `index` of a seed and records it, for people to look at: the hand as the Shadow
/// hand that the Adroit hand models, the object's parts, the target, and what the episode went
/// through (reach, carry, hold). Nothing is sensed in it: torques, forces and contacts are empty.
/// A frame's command holds the joints and the base that were reached, not the policy's action,
/// which the Shadow hand has no command for.
/// @throws BadInput if the task or the drawn hand cannot be used
recording::Recording record_episode(const TaskOptions& task, const Policy& policy,
                                    const EpisodeOptions& episode, std::uint64_t seed,
                                    std::size_t index);

}  // namespace palpate::learning
