// SPDX-License-Identifier: Apache-2.0
#include "tasks/relocate/exploration.hpp"

#include <stdexcept>
#include <string>

#include "palpate/skills/explore/explore_phase.hpp"

namespace palpate::relocate {
namespace {

constexpr double kFingerTime = 0.5;  // s for a posture of the fingers
constexpr double kSpeed = 0.3;       // m/s back to the start
constexpr double kRest = 0.5;        // s until the hand is at rest there

estimation::PoseEstimator estimator_of(const geometry::ObjectModel& object,
                                       const Eigen::Vector2d& place,
                                       estimation::EstimationOptions options, std::uint64_t seed) {
  options.place = place;
  return {object, options, seed};
}

/// From over the object: the fingers first, which would meet it on the way.
void go_back(skills::Executor& robot, const hand::HandCommand& start) {
  robot.move_fingers(start.positions, kFingerTime);
  robot.move_mount(start.mount, kSpeed);
  robot.wait(kRest);
}

}  // namespace

localization::Posterior explore(TaskHand& hand, const hand::Description& model,
                                const RoughPlace& rough, const RelocationOptions& options,
                                std::uint64_t seed, TouchRecorder* recorder) {
  auto estimator = estimator_of(rough.object, rough.place, options.resting, seed);
  skills::PickState state;
  state.place = rough.place;
  const geometry::KnownObject& object = rough.object.object();
  state.height = geometry::top_of(object, object.stable_poses.front());
  const hand::HandCommand start = hand.here();
  skills::Executor robot(hand, model, start,
                         recorder ? recorder->observer(rough.place) : skills::Executor::Observer{});
  try {
    skills::ExplorePhase phase(estimator, options.exploring);
    const auto report = skills::run_phase(phase, robot, state);
    if (report.status != skills::PhaseStatus::fault) go_back(robot, start);
    if (recorder) recorder->explored(report.outcome);
  } catch (const std::runtime_error&) {
    return {};  // a fault: the robot has stopped
  }
  return state.resting.value_or(localization::Posterior{});
}

localization::Posterior resting_pose(const geometry::ObjectModel& object,
                                     const Eigen::Vector2d& place, const hand::Description& model,
                                     const estimation::EventLog& log,
                                     const estimation::EstimationOptions& options,
                                     std::uint64_t seed) {
  return estimator_of(object, place, options, seed).resting(model, log);
}

}  // namespace palpate::relocate
