// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "palpate/pipeline/place.hpp"
#include "palpate/pipeline/regrasp_plan.hpp"

namespace palpate::pipeline {

/// A lighter hold on certainty than where the object is to stay: between two stances a wrong guess
/// is felt after the next transfer.
struct RegraspCourseOptions {
  int rounds = 5;                ///< transfers tried at most, repeated ones included
  double certain_between = 0.5;  ///< PlaceOptions::certain of a transfer that is not the last
  RegraspOptions plan;

  template <class Visitor>
  void visit(Visitor&& v) {
    v("rounds", rounds, 1, 100, "transfers tried at most, repeated ones included");
    v("certain_between", certain_between, 0.0, 1.0,
      "certainty asked of all transfers but the last");
    v.section("plan", plan);
  }
};

/// A transfer as it went.
struct RegraspRound {
  RegraspPlan plan;  ///< from the pose then estimated
  PickResult pick;
  std::optional<PlaceResult> place;  ///< none if the object was not held
};

enum class RegraspStatus {
  done,          ///< the object stands at the target, as far as was felt
  no_way,        ///< at last no chain of transfers led there
  not_held,      ///< the object could not be picked up
  out_of_rounds  ///< transfers went wrong again and again
};
std::string_view to_string(RegraspStatus status);

struct RegraspResult {
  RegraspStatus status = RegraspStatus::out_of_rounds;
  std::vector<RegraspRound> rounds;
};

/// Brings an object on the table into another pose, over other stances where that is needed. Before
/// every transfer its pose is estimated by touch anew, and the rest of the way planned anew.
///
/// @param robot  stands free above the table; the object is near the world's origin
/// @param T_world_target  a pose in which the object rests
RegraspResult regrasp(Robot& robot, const localization::ObjectModel& object,
                      const Eigen::Isometry3d& T_world_target, const PickOptions& pick_options,
                      const PlaceOptions& place_options, const RegraspCourseOptions& options,
                      std::uint64_t seed, const PhaseObserver& observer = {});

}  // namespace palpate::pipeline
