// SPDX-License-Identifier: Apache-2.0
#include "tasks/relocate/touch_recorder.hpp"

#include <string>

#include "palpate/core/version.hpp"
#include "palpate/hand/kinematics.hpp"
#include "palpate/recording/estimate_record.hpp"
#include "palpate/tasks/relocate/relocate_touch.hpp"
#include "tasks/relocate/episode_events.hpp"
#include "tasks/relocate/relocated_object.hpp"

namespace palpate::relocate {

TouchRecorder::TouchRecorder(recording::Recording& recording, const geometry::KnownObject& object,
                             const hand::Description& hand, std::uint64_t seed,
                             const localization::Posterior& resting)
    : recording_(recording) {
  recording_ = {};
  recording_.header = {std::string(version()), seed, object, hand, ""};
  recording_.estimates.push_back(recording::estimate_record(0, {resting, {}}));
}

void TouchRecorder::step(const hand::HandReading& reading, const RelocateTask& task,
                         const estimation::OnlineTracker& tracker) {
  const hand::Description& hand = recording_.header.hand;
  const hand::JointVector joints = shadow_joints(task.positions().head<kRelocateJoints>());
  const Eigen::Isometry3d T_world_object =
      object_pose(task.positions()) * recording_.header.object.T_mesh_object;
  recording_.frames.push_back({reading,
                               {hand::actuator_positions(hand, joints), reading.mount},
                               recording::FrameTruth{T_world_object, joints}});
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

}  // namespace palpate::relocate
