// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <vector>

#include "palpate/skills/reorient/regrasp_plan.hpp"
#include "skills/probe/probe_choice.hpp"

namespace palpate::skills {

/// A grasp from another side and what the fingers should sense there.
struct InformativeGrasp {
  grasping::GraspPlan plan;
  ExpectedGain expected_gain;
};

/// How safe and how different a grasp must be that is made for its information.
struct InformativeGraspOptions {
  grasping::GraspPlanOptions plan = many_grasps();
  double worst_cost = 0.3;    ///< of a grasp that holds
  double likely = 0.6;        ///< share of the poses in question for which it must hold
  std::vector<double> avoid;  ///< yaws (rad) of grasps made before
  double seconds = 14;        ///< that it takes
};

/// The one of the grasps of the likeliest pose from which most is to be learnt about which of the
/// poses in question is true, by where each finger should meet the object.
/// @param resting  the object's pose on the table, world
/// @return nothing if no grasp will do
std::optional<InformativeGrasp> most_informative_grasp(const geometry::ObjectModel& object,
                                                       const localization::Posterior& resting,
                                                       const GraspTool& tool,
                                                       const InformativeGraspOptions& options);

}  // namespace palpate::skills
