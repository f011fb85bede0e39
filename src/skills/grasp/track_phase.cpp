// SPDX-License-Identifier: Apache-2.0
#include "palpate/skills/grasp/track_phase.hpp"

#include <fmt/format.h>

#include <numbers>

namespace palpate::skills {

PhaseEnd TrackPhase::run(Executor& robot, PickState& state) {
  state.tracked.reset();
  const auto closed = robot.log().at(estimation::TouchEvent::closed),
             held = robot.log().at(estimation::TouchEvent::held);
  const auto& start = state.estimate.posterior;
  if (!closed || !held || localization::best_probability(start) <= 0) {
    return {false, "no pose to follow"};
  }
  state.tracked = estimation::track({.object = object_,
                                     .hand = robot.model(),
                                     .log = robot.log(),
                                     .start = start,
                                     .first = *closed,
                                     .last = *held,
                                     .errors = errors_},
                                    options_, seed_);
  const Eigen::Isometry3d T_base_start =
      robot.log().readings[*closed].base.pose().inverse() * start.modes.front().T_frame_object;
  const Eigen::Isometry3d& T_base_end = state.tracked->posterior.modes.front().T_frame_object;
  const double turn = rotation_distance(T_base_start.linear(), T_base_end.linear());
  const double way = (T_base_end.translation() - T_base_start.translation()).norm();
  return {true, fmt::format("in-hand motion {:.1f} deg, {:.1f} mm, {} slip{}",
                            180 / std::numbers::pi * turn, 1e3 * way, state.tracked->slips,
                            state.tracked->slips == 1 ? "" : "s")};
}

}  // namespace palpate::skills
