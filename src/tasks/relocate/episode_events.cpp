// SPDX-License-Identifier: Apache-2.0
#include "tasks/relocate/episode_events.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <ranges>
#include <string>

#include "palpate/core/se3.hpp"

namespace palpate::relocate {
namespace {

using recording::EventKind;

constexpr double kLifted = 0.015, kArrived = 0.05;  // m

/// Which phase the object is in: still on the table, on its way, or at the target.
const char* phase_of(const Eigen::Vector3d& object, double start_height,
                     const Eigen::Vector3d& target) {
  if (object.z() < start_height + kLifted) return kFirstPhase;
  return (object - target).norm() < kArrived ? "hold" : "carry";
}

/// @param begin  s, of the policy; what was before is no phase of the episode
void add_phases(const Eigen::Vector3d& target, double begin, recording::Recording& recording) {
  const auto first = std::ranges::find_if(
      recording.frames, [&](const auto& frame) { return frame.reading.time >= begin; });
  if (first == recording.frames.end()) return;
  const double start_height = first->truth->T_world_object.translation().z();
  std::string phase;
  for (const auto& frame : std::ranges::subrange(first, recording.frames.end())) {
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

}  // namespace

void add_episode_events(const Eigen::Isometry3d& T_world_target, recording::Recording& recording) {
  if (recording.frames.empty()) return;
  const double begin = recording.estimates.empty() ? 0 : recording.estimates.front().time;
  recording.events.insert(
      recording.events.begin(),
      {0, EventKind::note, kFirstPhase,
       fmt::format("target {}", fmt::join(pose_to_row_major(T_world_target), " "))});
  add_phases(T_world_target.translation(), begin, recording);
}

}  // namespace palpate::relocate
