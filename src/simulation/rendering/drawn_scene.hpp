// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "palpate/simulation/rendering/renderer.hpp"
#include "simulation/world/mujoco_handles.hpp"

namespace palpate::simulation {

/// A model that is only looked at: the hand's drawn meshes, the object's true mesh, a table,
/// lights.
struct DrawnScene {
  ModelHandle model;
  Eigen::Isometry3d T_base_hand = Eigen::Isometry3d::Identity();
  std::vector<int> joint_positions;  ///< addresses in qpos
  int hand_position = -1;            ///< address in qpos
  int object_position = -1;          ///< address in qpos
};

/// @param width, height  of the pictures, pixels
/// @throws BadInput if the hand's or the object's mesh cannot be used
DrawnScene compose_drawn_scene(const hand::Description& hand, const geometry::KnownObject& object,
                               int width, int height);

/// Moves the hand and the object there.
/// @throws BadInput for a value that is not finite
void pose_scene(const DrawnScene& scene, const DrawnState& state, mjData& data);

}  // namespace palpate::simulation
