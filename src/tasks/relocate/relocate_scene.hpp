// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "palpate/tasks/relocate/relocate_task.hpp"
#include "simulation/world/mujoco_handles.hpp"

namespace palpate::relocate {

inline constexpr double kControlStep = 0.01;  ///< s

/// The compiled model of the relocate task, and where in it each thing is.
struct RelocateScene {
  simulation::ModelHandle model;
  int object = -1;         ///< body
  int palm = -1;           ///< site
  int target = -1;         ///< site
  int object_joint = -1;   ///< address in qpos
  int substeps = 0;        ///< of physics, each control step of 10 ms
  std::vector<char> hand;  ///< for each geom, whether it is the hand's
  std::vector<char> held;  ///< for each geom, whether it is the object's
  std::vector<int> tips;   ///< geoms of the fingertips, in the order of the Shadow hand's fingers
};

/// What is kept in the model for drawing it.
enum class RelocateVisuals { none, drawn };

/// Composes hand, table, object and target.
/// @throws BadInput if the hand's model is missing or the object cannot be used
RelocateScene compose_relocate_scene(const RelocateObject& object, const RelocatePhysics& physics,
                                     RelocateVisuals visuals);

}  // namespace palpate::relocate
