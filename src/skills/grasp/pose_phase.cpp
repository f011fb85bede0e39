// SPDX-License-Identifier: Apache-2.0
#include "skills/grasp/pose_phase.hpp"

#include <fmt/format.h>

namespace palpate::skills {

PhaseEnd PosePhase::run(Executor& robot, PickState& state) {
  state.estimate = estimator_.held(robot.model(), robot.log(), robot.log().at(instant_));
  const auto& posterior = state.estimate.posterior;
  if (posterior.modes.empty()) return {false, "no pose explains the contacts"};
  return {
      true,
      fmt::format("{} ({:.2f}), {} mode{}, {} contacts", localization::to_string(posterior.status),
                  localization::best_probability(posterior), posterior.modes.size(),
                  posterior.modes.size() == 1 ? "" : "s", state.estimate.contacts.size())};
}

}  // namespace palpate::skills
