// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "palpate/tasks/relocate/relocation.hpp"
#include "tasks/relocate/task_hand.hpp"
#include "tasks/relocate/touch_recorder.hpp"

namespace palpate::relocate {

/// A resting object as far as it is known before it is touched.
struct RoughPlace {
  const geometry::ObjectModel& object;  ///< its first stable pose is the one that it stands in
  Eigen::Vector2d place;                ///< of its centroid, roughly, m
};

struct Exploration {
  localization::Posterior resting;  ///< no modes: not known
  std::string outcome;              ///< one line
};

/// Touches the resting object with the task's own hand, which goes back to where it started.
/// @param recorder  of all that it senses, if not null
/// @return without modes where no pose explains what was sensed, or a fault stopped the hand
Exploration explore(TaskHand& hand, const RoughPlace& rough, const RelocationOptions& options,
                    std::uint64_t seed, TouchRecorder* recorder);

/// How the object rests, by the log of an exploration.
localization::Posterior resting_pose(const RoughPlace& rough, const hand::Description& hand,
                                     const estimation::EventLog& log,
                                     estimation::EstimationOptions options, std::uint64_t seed);

}  // namespace palpate::relocate
