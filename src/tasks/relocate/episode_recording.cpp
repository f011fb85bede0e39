// SPDX-License-Identifier: Apache-2.0
#include "palpate/tasks/relocate/episode_recording.hpp"

#include <string>

#include "palpate/core/error.hpp"
#include "palpate/core/version.hpp"
#include "palpate/hand/kinematics.hpp"
#include "palpate/recording/estimate_record.hpp"
#include "palpate/recording/touch_log.hpp"
#include "palpate/tasks/relocate/drawn_task.hpp"
#include "palpate/tasks/relocate/relocate_task.hpp"
#include "tasks/relocate/episode_events.hpp"
#include "tasks/relocate/exploration.hpp"

namespace palpate::relocate {
namespace {

/// A frame of an episode, at the positions after so many steps.
recording::Frame frame_at(DrawnTask& drawn, int step, const Eigen::VectorXd& positions) {
  const simulation::DrawnState state = drawn.at(positions);
  recording::Frame frame;
  frame.reading.time = step * hand::kTick;
  frame.reading.joints = state.joints;
  frame.reading.mount = state.mount;
  frame.reading.torques.setZero(drawn.hand().actuator_count());
  frame.reading.contacts.resize(drawn.hand().fingers.size());
  frame.command = {hand::actuator_positions(drawn.hand(), state.joints), state.mount};
  frame.truth = {state.T_world_object, state.joints};
  return frame;
}

/// The pose of the resting object, from its exploration if there was one that led to a pose.
localization::Posterior resting(const recording::Recording& recording,
                                const geometry::ObjectModel& object,
                                const estimation::EstimationOptions& options) {
  if (const auto place = explored_place(recording)) {
    auto estimated = resting_pose({object, *place}, recording.header.hand,
                                  recording::event_log(recording), options, recording.header.seed);
    // Other options than the episode's may find no pose.
    if (estimated.residual_mass() < 1) return estimated;
  }
  return recording::posterior_of(recording.estimates.front());
}

}  // namespace

recording::Recording record_episode(const TaskOptions& task, const Policy& policy,
                                    const EpisodeOptions& episode, std::uint64_t seed,
                                    std::size_t index) {
  const auto model = make_model(task);
  DrawnTask drawn(task, model);
  recording::Recording recording;
  recording.header = {std::string(version()), seed, drawn.object(), drawn.hand(), ""};
  const auto start = episode_start(episode, seed, index);
  RelocateTask run(model);
  const auto outcome =
      run_episode(run, start, episode.horizon, [&](int step, const PolicyInput& input) {
        recording.frames.push_back(frame_at(drawn, step, run.positions()));
        return policy.act(input);
      });
  if (!outcome.diverged)
    recording.frames.push_back(frame_at(drawn, outcome.steps, run.positions()));
  Eigen::Isometry3d T_world_target = recording.frames.front().truth->T_world_object;
  T_world_target.translation() = start.target;
  add_episode_events(T_world_target, recording);
  return recording;
}

bool is_episode(const recording::Recording& recording) {
  return !recording.events.empty() && recording.events.front().phase == kFirstPhase;
}

estimation::HeldPoseEstimate replay_episode(const recording::Recording& recording,
                                            const RelocationOptions& options) {
  if (recording.estimates.empty()) {
    throw BadInput("an episode with the true pose of the object: nothing was estimated in it");
  }
  const geometry::ObjectModel object(recording.header.object);
  const double begin = recording.estimates.front().time;
  estimation::OnlineTracker tracker(object, recording.header.hand,
                                    resting(recording, object, options.resting), options.tracking,
                                    recording.header.seed);
  for (const recording::Frame& frame : recording.frames) {
    if (frame.reading.time >= begin) tracker.update(frame.reading);
  }
  return tracker.newest();
}

}  // namespace palpate::relocate
