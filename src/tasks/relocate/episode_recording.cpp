// SPDX-License-Identifier: Apache-2.0
#include "palpate/tasks/relocate/episode_recording.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <string>

#include "palpate/core/se3.hpp"
#include "palpate/core/version.hpp"
#include "palpate/hand/kinematics.hpp"
#include "palpate/tasks/relocate/drawn_task.hpp"
#include "palpate/tasks/relocate/relocate_task.hpp"

namespace palpate::relocate {
namespace {

using recording::Event;
using recording::EventKind;

constexpr double kLifted = 0.015, kArrived = 0.05;  // m

/// A frame of an episode, at the positions after so many steps.
recording::Frame frame_at(DrawnTask& drawn, int step, const Eigen::VectorXd& positions) {
  const simulation::DrawnState state = drawn.at(positions);
  recording::Frame frame;
  frame.reading.time = step * hand::kTick;
  frame.reading.joints = state.joints;
  frame.reading.base = state.base;
  frame.reading.torques.setZero(drawn.hand().actuator_count());
  frame.reading.contacts.resize(drawn.hand().fingers.size());
  frame.command = {hand::actuator_positions(drawn.hand(), state.joints), state.base};
  frame.truth = {state.T_world_object, state.joints};
  return frame;
}

/// Which phase the object is in: still on the table, on its way, or at the target.
const char* phase_of(const Eigen::Vector3d& object, double start_height,
                     const Eigen::Vector3d& target) {
  if (object.z() < start_height + kLifted) return "reach";
  return (object - target).norm() < kArrived ? "hold" : "carry";
}

void add_phases(const Eigen::Vector3d& target, recording::Recording& recording) {
  const double start_height = recording.frames.front().truth->T_world_object.translation().z();
  std::string phase;
  for (const recording::Frame& frame : recording.frames) {
    const double time = frame.reading.time;
    const char* const now =
        phase_of(frame.truth->T_world_object.translation(), start_height, target);
    if (phase == now) continue;
    if (!phase.empty()) recording.events.push_back({time, EventKind::end, phase, "done"});
    phase = now;
    recording.events.push_back({time, EventKind::begin, phase, ""});
  }
  recording.events.push_back({recording.frames.back().reading.time, EventKind::end, phase, "done"});
}

/// The note that the page shows as the place where the object is to go: a pose, row by row.
Event target_note(const Eigen::Isometry3d& T_world_target) {
  return {0, EventKind::note, "reach",
          fmt::format("target {}", fmt::join(pose_to_row_major(T_world_target), " "))};
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
  recording.events.push_back(target_note(T_world_target));
  add_phases(start.target, recording);
  return recording;
}

}  // namespace palpate::relocate
