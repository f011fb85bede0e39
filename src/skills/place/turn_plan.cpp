// SPDX-License-Identifier: Apache-2.0
#include "skills/place/turn_plan.hpp"

#include <fmt/format.h>

#include <numbers>

#include "palpate/core/angle.hpp"
#include "palpate/hand/nearest_mount.hpp"

namespace palpate::skills {
namespace {

hand::MountPosition wanted_mount(const TurnQuestion& question) {
  if (question.search.goal)
    return hand::nearest_mount(question.search.goal->mount.pose(), question.mount);
  return hand::nearest_mount(question.T_world_target * question.held.T_mount_object_flat.inverse(),
                             question.mount);
}

}  // namespace

std::optional<InHandReorientation> plan_in_hand_reorientation(
    PlaceStrategy strategy, const TurnQuestion& question, const InHandReorientationOptions& options,
    const std::function<bool(const HeldObject&)>& reaches) {
  const GoalSearch& search = question.search;
  const bool asked_for = strategy == PlaceStrategy::fingers;
  if (!asked_for && (strategy != PlaceStrategy::automatic || search.goal)) return std::nullopt;
  const hand::MountPosition wanted = wanted_mount(question);
  InHandReorientation turn;
  turn.mount_rotation = share_of_fingers(question.mount, wanted, std::numbers::pi).norm();
  turn.asked = share_of_fingers(question.mount, wanted, options.max);
  if (search.goal) {
    if (turn.asked.norm() < options.min) return std::nullopt;
    turn.why =
        fmt::format("asked for: {:.1f} of the {:.1f} deg that the mount would turn",
                    kDegreesPerRadian * turn.asked.norm(), kDegreesPerRadian * turn.mount_rotation);
    return turn;
  }
  const auto reaching =
      turn_that_reaches(question.held, question.mount, turn.asked, options.max, reaches);
  if (!reaching) return std::nullopt;
  turn.asked = *reaching;
  turn.why =
      fmt::format("unreachable as it is held ({}), reachable turned by {:.1f} deg in the hand",
                  search.obstacle, kDegreesPerRadian * turn.asked.norm());
  return turn;
}

}  // namespace palpate::skills
