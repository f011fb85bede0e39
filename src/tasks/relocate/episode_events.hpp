// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "palpate/recording/recording.hpp"

namespace palpate::relocate {

inline constexpr const char* kFirstPhase = "reach";

/// Notes the target of an episode, and the phases that its frames went through: reach, while the
/// object is on the table, then carry, and hold while it is near the target. By touch the policy
/// begins with the first estimate; what was before is not among these.
void add_episode_events(const Eigen::Isometry3d& T_world_target, recording::Recording& recording);

}  // namespace palpate::relocate
