// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "palpate/skills/place/place.hpp"
#include "palpate/skills/place/regrasp.hpp"
#include "palpate/skills/place_strategy.hpp"

namespace palpate::skills {

/// By which strategy the object was brought to its target, and why.
struct StrategyTaken {
  /// What became of a planned transfer.
  struct Round {
    RegraspPlan plan;
    std::optional<PlaceStatus> place;  ///< none if the object was not held
  };
  PlaceStrategy strategy = PlaceStrategy::wrist;  ///< wrist, fingers or regrasp
  std::string reason;
  std::optional<InHandReorientation> reorientation;  ///< the last one by the fingers
  std::optional<RegraspStatus> regrasp;              ///< how that ended
  std::vector<Round> rounds;                         ///< of regrasping
};

/// All picks and placings on the way of an object to its target.
struct PickAndPlaceResult {
  /// The last one, with the phases of all before. It has the fault that stopped the robot, the
  /// phase that this ended, and all phases, be it in a pick or in a placing.
  PickResult picked;
  /// The last one; its phases are empty if a pick came after. None after a fault.
  std::optional<PlaceResult> place;
  StrategyTaken strategy;
};

/// With a firmer grasp for a target that may be in another stable pose (a pose): turned about the
/// axis through its contacts, the object hangs on their friction.
PickOptions firm_enough(const PickOptions& pick_options, const PlaceTarget& target,
                        const PlaceOptions& options);

/// Picks the object and brings it to its target: `picks` times in one hold; by regrasp() where that
/// was asked for, or where one hold could not bring it there: it was put back as unreachable, or
/// for another reason on its way into another stable pose. The fingers turn it in the first hold
/// alone: what they did not bring there is then left to the mount.
///
/// @param robot  stands free above the table; the object is near the world's origin
/// @throws BadInput for a PlaceOptions::strategy that does not exist, before anything moves
PickAndPlaceResult pick_and_place(Executor& robot, const PickAndPlaceTask& task,
                                  const PhaseObserver& observer = {});

}  // namespace palpate::skills
