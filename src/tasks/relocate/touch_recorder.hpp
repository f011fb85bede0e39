// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "palpate/estimation/online_tracker.hpp"
#include "palpate/recording/recording.hpp"
#include "palpate/tasks/relocate/relocate_task.hpp"

namespace palpate::relocate {

/// Records an episode by touch: what the hand sensed, what was estimated from it, and the truth.
class TouchRecorder {
 public:
  /// @param recording  filled; its header lacks the configuration
  /// @param seed  of the tracker
  /// @param resting  pose on the table, in the world, with which the tracker begins
  TouchRecorder(recording::Recording& recording, const geometry::KnownObject& object,
                const hand::Description& hand, std::uint64_t seed,
                const localization::Posterior& resting);

  /// After the tracker has had the reading.
  void step(const hand::HandReading& reading, const RelocateTask& task,
            const estimation::OnlineTracker& tracker);

  /// @param target  of the origin of the task's own frame of the object, m
  void finish(const Eigen::Vector3d& target);

 private:
  recording::Recording& recording_;
  int estimates_ = 0;
};

}  // namespace palpate::relocate
