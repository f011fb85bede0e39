// SPDX-License-Identifier: Apache-2.0
#include "tasks/relocate/touch_recorder.hpp"

#include <fmt/format.h>

#include <sstream>
#include <string>
#include <utility>

#include "palpate/core/error.hpp"
#include "palpate/core/plausible.hpp"
#include "palpate/core/version.hpp"
#include "palpate/evaluation/credible_poses.hpp"
#include "palpate/hand/kinematics.hpp"
#include "palpate/recording/estimate_record.hpp"
#include "palpate/recording/touch_log.hpp"
#include "palpate/tasks/relocate/relocate_touch.hpp"
#include "tasks/relocate/episode_events.hpp"
#include "tasks/relocate/relocated_object.hpp"

namespace palpate::relocate {
namespace {

constexpr const char* kExplore = "explore";
constexpr std::string_view kPlace = "rough place ";

}  // namespace

TouchRecorder::TouchRecorder(const RelocateTask& task, const geometry::KnownObject& object,
                             const hand::Description& hand, std::uint64_t seed,
                             recording::Recording& recording)
    : task_(task), recording_(recording) {
  recording_ = {};
  recording_.header = {std::string(version()), seed, object, hand, ""};
}

skills::Executor::Observer TouchRecorder::observer() {
  return {.on_tick = [this](const auto& reading, const auto& command) { frame(reading, command); },
          .on_event =
              [this](estimation::TouchEvent touch) {
                event(recording::EventKind::note, recording::touch_note(touch));
              },
          .on_posterior =
              [this](const localization::Posterior& posterior) {
                event(recording::EventKind::note, evaluation::credible_note(posterior));
              }};
}

void TouchRecorder::explored(std::string_view outcome, const Eigen::Vector2d* place) {
  if (recording_.frames.empty()) return;
  if (place) {
    event(recording::EventKind::note, fmt::format("{}{} {}", kPlace, place->x(), place->y()));
  }
  event(recording::EventKind::end, std::string(outcome));
}

void TouchRecorder::begin(const localization::Posterior& resting, double time) {
  recording_.estimates.push_back(recording::estimate_record(time, {resting, {}}));
}

void TouchRecorder::step(const hand::HandReading& reading,
                         const estimation::OnlineTracker& tracker) {
  const hand::Description& hand = recording_.header.hand;
  const hand::JointVector joints = shadow_joints(task_.positions().head<kRelocateJoints>());
  frame(reading, {hand::actuator_positions(hand, joints), reading.mount});
  if (tracker.estimates() == estimates_) return;
  estimates_ = tracker.estimates();
  recording_.estimates.push_back(recording::estimate_record(reading.time, tracker.newest()));
}

void TouchRecorder::finish(const Eigen::Vector3d& target) {
  const Eigen::Isometry3d& T_task_object = recording_.header.object.T_mesh_object;
  const Eigen::Isometry3d T_world_first = recording_.frames.front().truth->T_world_object;
  Eigen::Isometry3d T_world_task = T_world_first * T_task_object.inverse();
  T_world_task.translation() = target;
  add_episode_events(T_world_task * T_task_object, recording_);
}

void TouchRecorder::frame(const hand::HandReading& reading, const hand::HandCommand& command) {
  const Eigen::Isometry3d T_world_object =
      object_pose(task_.positions()) * recording_.header.object.T_mesh_object;
  const hand::JointVector joints = shadow_joints(task_.positions().head<kRelocateJoints>());
  recording_.frames.push_back({reading, command, recording::FrameTruth{T_world_object, joints}});
  if (recording_.frames.size() == 1 && recording_.estimates.empty()) {
    event(recording::EventKind::begin, "");
  }
}

void TouchRecorder::event(recording::EventKind kind, std::string text) {
  recording_.events.push_back(
      {recording_.frames.back().reading.time, kind, kExplore, std::move(text)});
}

std::optional<Eigen::Vector2d> explored_place(const recording::Recording& recording) {
  for (const recording::Event& event : recording.events) {
    if (event.phase != kExplore || !event.text.starts_with(kPlace)) continue;
    std::istringstream values(event.text.substr(kPlace.size()));
    Eigen::Vector2d place;
    const bool read = values >> place.x() >> place.y() && values.eof();
    if (read && place.cwiseAbs().maxCoeff() <= kMaxLength) return place;
    throw BadInput(fmt::format("malformed rough place in the recording: {:?}", event.text));
  }
  return std::nullopt;
}

}  // namespace palpate::relocate
