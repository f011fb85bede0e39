// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "palpate/tasks/relocate/relocation.hpp"
#include "tasks/relocate/task_hand.hpp"
#include "tasks/relocate/touch_recorder.hpp"

namespace palpate::relocate {

/// A resting object as far as it is known before it is touched.
struct RoughPlace {
  const geometry::ObjectModel& object;  ///< its first stable pose is the one that it stands in
  Eigen::Vector2d place;                ///< of its centroid, roughly, m
};

/// Touches the resting object with the task's own hand, which goes back to where it started.
/// @param recorder  of all that it senses, if not null
/// @return how the object rests; no modes where no pose explains what was sensed, or the hand was
///   stopped by a fault
localization::Posterior explore(TaskHand& hand, const hand::Description& model,
                                const RoughPlace& rough, const RelocationOptions& options,
                                std::uint64_t seed, TouchRecorder* recorder);

/// The same estimate from what was sensed.
/// @param place  of the object's centroid, roughly, m
localization::Posterior resting_pose(const geometry::ObjectModel& object,
                                     const Eigen::Vector2d& place, const hand::Description& model,
                                     const estimation::EventLog& log,
                                     const estimation::EstimationOptions& options,
                                     std::uint64_t seed);

}  // namespace palpate::relocate
