// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "palpate/estimation/online_tracker.hpp"
#include "palpate/recording/recording.hpp"
#include "palpate/skills/executor.hpp"
#include "palpate/tasks/relocate/relocate_task.hpp"

namespace palpate::relocate {

/// Records an episode by touch: what the hand sensed, what was estimated from it, and the truth.
class TouchRecorder {
 public:
  /// @param task  which is recorded; must outlive the recorder
  /// @param recording  filled; its header lacks the configuration
  /// @param seed  of the estimates
  TouchRecorder(const RelocateTask& task, const geometry::KnownObject& object,
                const hand::Description& hand, std::uint64_t seed, recording::Recording& recording);

  /// Records what a robot senses while it explores; must not outlive the recorder.
  skills::Executor::Observer observer();

  /// The exploration has ended so.
  /// @param place  of the object (m), from which its pose was estimated; null: it was not
  void explored(std::string_view outcome, const Eigen::Vector2d* place);

  /// The policy begins, with this pose on the table, in the world.
  void begin(const localization::Posterior& resting, double time);

  /// After the tracker has had the reading.
  void step(const hand::HandReading& reading, const estimation::OnlineTracker& tracker);

  /// @param target  of the origin of the task's own frame of the object, m
  void finish(const Eigen::Vector3d& target);

 private:
  void frame(const hand::HandReading& reading, const hand::HandCommand& command);
  void event(recording::EventKind kind, std::string text);

  const RelocateTask& task_;
  recording::Recording& recording_;
  int estimates_ = 0;
};

/// The rough place of the object that an exploration was given; nothing if there was none, or it
/// led to no pose.
/// @throws BadInput for a malformed place
std::optional<Eigen::Vector2d> explored_place(const recording::Recording& recording);

}  // namespace palpate::relocate
