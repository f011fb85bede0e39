// SPDX-License-Identifier: Apache-2.0
#include "tasks/relocate/exploration.hpp"

#include "palpate/skills/explore/explore_phase.hpp"

namespace palpate::relocate {
namespace {

constexpr double kFingerTime = 0.5;  // s for a posture of the fingers
constexpr double kSpeed = 0.3;       // m/s back to the start
constexpr double kRest = 0.5;        // s until the hand is at rest there

/// From over the object: the fingers first, which would meet it on the way.
void go_back(skills::Executor& robot, const hand::HandCommand& start) {
  robot.move_fingers(start.positions, kFingerTime);
  robot.move_mount(start.mount, kSpeed);
  robot.wait(kRest);
}

/// Touches the object as a pick does, and goes back. @return how that ended, in one line
std::string touch_object(skills::Executor& robot, const RoughPlace& rough,
                         const skills::ExploreOptions& options,
                         const estimation::EstimationOptions& resting, std::uint64_t seed) {
  estimation::PoseEstimator estimator(rough.object, resting, seed);
  const geometry::KnownObject& object = rough.object.object();
  skills::PickState state;
  state.place = rough.place;
  state.height = geometry::top_of(object, object.stable_poses.front());
  const hand::HandCommand start = robot.command();
  skills::ExplorePhase phase(estimator, options);
  std::string outcome = skills::run_phase(phase, robot, state).outcome;
  if (robot.fault()) return outcome;
  try {
    go_back(robot, start);
  } catch (const skills::SafetyStop& stop) {
    outcome = stop.what();
  } catch (const skills::Unreachable& error) {
    robot.make_safe(skills::Fault::exception, error.what());
    outcome = error.what();
  }
  return outcome;
}

}  // namespace

Exploration explore(TaskHand& hand, const RoughPlace& rough, const RelocationOptions& options,
                    std::uint64_t seed, TouchRecorder* recorder) {
  skills::Executor robot(hand, hand.description(), hand.here(),
                         recorder ? recorder->observer() : skills::Executor::Observer{});
  estimation::EstimationOptions resting = options.resting;
  resting.place = rough.place;
  Exploration result;
  result.outcome = touch_object(robot, rough, options.exploring, resting, seed);
  if (!robot.fault()) {
    result.resting = resting_pose(rough, hand.description(), robot.log(), options.resting, seed);
  }
  const bool known = result.resting.residual_mass() < 1;
  if (recorder) recorder->explored(result.outcome, known ? &rough.place : nullptr);
  return result;
}

localization::Posterior resting_pose(const RoughPlace& rough, const hand::Description& hand,
                                     const estimation::EventLog& log,
                                     estimation::EstimationOptions options, std::uint64_t seed) {
  options.place = rough.place;
  return estimation::PoseEstimator(rough.object, options, seed).resting(hand, log);
}

}  // namespace palpate::relocate
