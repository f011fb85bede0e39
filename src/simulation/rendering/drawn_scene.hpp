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
  Eigen::Isometry3d T_mount_hand = Eigen::Isometry3d::Identity();
  std::vector<int> joint_positions;  ///< addresses in qpos
  int hand_position = -1;            ///< address in qpos
  int object_position = -1;          ///< address in qpos
  int object_geom = -1;              ///< of the object's mesh
};

/// @param width, height  of the pictures, pixels
/// @throws BadInput if the hand's or the object's mesh cannot be used
DrawnScene compose_drawn_scene(const hand::Description& hand, const geometry::KnownObject& object,
                               int width, int height);

/// Moves the hand and the object there.
/// @throws BadInput for a value that is not finite
void pose_scene(const DrawnScene& scene, const DrawnState& state, mjData& data);

/// Gives the object its opacity, and adds its ghosts to what mjv_updateScene has put together.
/// @throws BadInput for an opacity outside 0..1, a pose that is not finite, or too many ghosts
void draw_ghosts(const DrawnScene& scene, const DrawnState& state, mjvScene& drawn);

}  // namespace palpate::simulation
