// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "palpate/skills/place/place.hpp"
#include "palpate/skills/reorient/regrasp_plan.hpp"

namespace palpate::skills {

/// A transfer as it went.
struct RegraspRound {
  RegraspPlan plan;  ///< from the pose then estimated
  PickResult pick;
  std::optional<PlaceResult> place;  ///< none if the object was not held
};

enum class RegraspStatus {
  done,           ///< the object stands at the target, as far as was sensed
  no_way,         ///< at last no chain of transfers led there
  not_held,       ///< the object could not be picked up
  lost,           ///< it fell, does not leave the hand, or is not where it was put
  out_of_rounds,  ///< transfers went wrong again and again
  stopped         ///< a fault stopped the robot for good, in the last round's pick or placing
};
std::string_view to_string(RegraspStatus status);

struct RegraspResult {
  RegraspStatus status = RegraspStatus::out_of_rounds;
  std::vector<RegraspRound> rounds;
};

/// Brings an object on the table to a target, over other stable poses where that is needed. Before
/// every transfer its pose is estimated by touch again, and the rest of the way planned again. A
/// spot is reached in the stable pose that the object has; for it only the grasp is chosen.
///
/// @param robot  stands free above the table; the object is near the world's origin
/// @param task   with PlaceOptions::regrasp, the sequence's own options
RegraspResult regrasp(Executor& robot, const PickAndPlaceTask& task,
                      const PhaseObserver& observer = {});

}  // namespace palpate::skills
