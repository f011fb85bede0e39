// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <optional>

#include "palpate/skills/place/place.hpp"
#include "palpate/skills/place_strategy.hpp"

namespace palpate::skills {

/// A held object, and what the mount alone can do for it.
struct TurnQuestion {
  hand::MountPosition mount;  ///< where it is now
  Eigen::Isometry3d T_world_target;
  const HeldObject& held;
  const GoalSearch& search;
};

/// Decides whether the fingers turn the object first: where that was asked for, as much of the
/// mount's turn as they can; else only where it makes a target reachable that is not.
/// @param reaches  whether the object, held so, can be brought to the target
std::optional<InHandReorientation> plan_in_hand_reorientation(
    PlaceStrategy strategy, const TurnQuestion& question, const InHandReorientationOptions& options,
    const std::function<bool(const HeldObject&)>& reaches);

}  // namespace palpate::skills
