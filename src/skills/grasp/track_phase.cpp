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
  const Eigen::Isometry3d T_mount_start =
      robot.log().readings[*closed].mount.pose().inverse() * start.modes.front().T_frame_object;
  const Eigen::Isometry3d& T_mount_end = state.tracked->posterior.modes.front().T_frame_object;
  const double turn = rotation_distance(T_mount_start.linear(), T_mount_end.linear());
  const double way = (T_mount_end.translation() - T_mount_start.translation()).norm();
  return {true, fmt::format("in-hand motion {:.1f} deg, {:.1f} mm, {} slip{}",
                            180 / std::numbers::pi * turn, 1e3 * way, state.tracked->slips,
                            state.tracked->slips == 1 ? "" : "s")};
}

}  // namespace palpate::skills
