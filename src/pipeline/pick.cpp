// SPDX-License-Identifier: Apache-2.0
#include "palpate/pipeline/pick.hpp"

#include <algorithm>
#include <numbers>

#include "course.hpp"
#include "load.hpp"
#include "palpate/pipeline/explore_phase.hpp"
#include "palpate/pipeline/locate_phase.hpp"
#include "palpate/pipeline/probe_phase.hpp"
#include "palpate/pipeline/release_phase.hpp"
#include "palpate/pipeline/track_phase.hpp"

namespace palpate::pipeline {
namespace {

constexpr double kNextSide = 2 * std::numbers::pi / 3;  // rad between attempts

bool has(const TouchLog& log, Mark mark) {
  return std::any_of(log.moments.begin(), log.moments.end(),
                     [mark](const auto& moment) { return moment.mark == mark; });
}

PickResult run_pick(Robot& robot, const localization::ObjectModel& object,
                    const PickOptions& options, std::uint64_t seed, const PhaseObserver& observer,
                    const GraspChooser& choose) {
  PickState state;
  PickResult result;
  Course course(robot, state, result.phases, result.failed_phase, observer);
  const double weight = object.object().mass * kGravity;
  const double press = pressure(options.grasp, object.object());

  // Without a pose to aim by, the grasp goes for the rough place.
  const auto explore = [&] {
    if (options.explore.touches > 0) {
      course.run(ExplorePhase(object, options.explore, options.locate, seed));
    }
    return true;
  };
  const auto estimate = [&] {
    result.before_probe.reset();
    result.before_lift.reset();
    if (options.estimate_before_lift &&
        course.run(LocatePhase(object, options.locate, seed, Mark::closed))) {
      result.before_probe = result.before_lift = state.estimate;
      if (options.probe.most > 0) {
        course.run(ProbePhase(object, options.probe, options.locate, press, seed));
        result.before_lift = state.estimate;
      }
    }
    return true;
  };
  if (options.calibrate.touches > 0 && robot.model().link_error > 0 &&
      !has(robot.log(), Mark::on_table)) {
    course.run(CalibratePhase(options.calibrate));
  }
  while (!result.held && result.attempts < options.attempts) {
    if (result.attempts++ > 0) {
      course.run(ReleasePhase());
      state.yaw += kNextSide;
    }
    result.held = course.run(FeelPhase(options.feel)) && explore() &&
                  course.run(GraspPhase(options.grasp, object, choose)) && estimate() &&
                  course.run(LiftPhase(options.lift, weight));
  }
  result.resting = state.resting;
  if (!result.held) return result;
  result.failed_phase.clear();
  if (result.before_lift &&
      course.run(TrackPhase(object, options.track, options.locate.errors, seed))) {
    result.tracked = state.tracked;
  }
  course.run(LocatePhase(object, options.locate, seed));
  result.estimate = state.estimate;
  return result;
}

}  // namespace

PickResult pick(Robot& robot, const localization::ObjectModel& object, const PickOptions& options,
                std::uint64_t seed, const PhaseObserver& observer, const GraspChooser& choose) {
  PickResult result = run_pick(robot, object, options, seed, observer, choose);
  if (observer.on_picked) observer.on_picked(result);
  return result;
}

}  // namespace palpate::pipeline
