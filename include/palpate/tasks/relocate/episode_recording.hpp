// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "palpate/recording/recording.hpp"
#include "palpate/tasks/relocate/relocation.hpp"

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

/// Whether it is an episode of the relocate task, with the true pose or by touch.
bool is_episode(const recording::Recording& recording);

/// Estimates the object's pose in an episode by touch again, from its readings alone; where the
/// object was not explored, from the pose that was assumed of it, too. With the options of the
/// recording, the result is its last estimate, bit for bit.
/// @throws BadInput for an episode with the true pose, in which nothing was estimated
estimation::HeldPoseEstimate replay_episode(const recording::Recording& recording,
                                            const RelocationOptions& options);

}  // namespace palpate::relocate
