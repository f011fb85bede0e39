// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <memory>
#include <vector>

#include "palpate/geometry/objects/known_object.hpp"
#include "palpate/geometry/query/capsule_collider.hpp"
#include "palpate/hand/arm.hpp"
#include "palpate/hand/description.hpp"
#include "palpate/simulation/world/world.hpp"
#include "simulation/world/drawn_errors.hpp"
#include "simulation/world/mujoco_handles.hpp"

namespace palpate::simulation {

inline const Eigen::Vector3d kSecondHalf{0.02, 0.03, 0.04};  ///< m, half extents of a second object

/// What stands fast about the object.
struct Surroundings {
  Eigen::Matrix3d R_world_table = Eigen::Matrix3d::Identity();  ///< through the world's origin
  planning::Fixture fixture = {};                               ///< in the table's frame
  const hand::ArmDescription* arm = nullptr;                    ///< none: a floating mount
};

/// The model of table, hand and object, and where in it each thing is.
struct Scene {
  ModelHandle model;
  int root = -1;                          ///< body that the hand starts with
  std::vector<int> links = {};            ///< of the hand, by body; -1 for other bodies
  std::vector<int> joint_positions = {};  ///< addresses in qpos
  std::vector<int> actuators = {};        ///< ids
  std::vector<int> mount_positions = {};  ///< addresses in qpos: x y z yaw pitch roll, or the arm's
  std::vector<int> base_actuators = {};   ///< ids, in that order
  std::vector<int> tips = {};             ///< geoms, one a finger
  std::vector<std::unique_ptr<const geometry::RoundedHull>> tip_hulls = {};  ///< of those with one
  int table = -1;                                                            ///< geom
  std::vector<int> fixture = {};                                             ///< geoms
  int object = -1;                                                           ///< body
  int object_position = -1;                                                  ///< address in qpos
  int second = -1;           ///< geom of a second object; -1: there is none
  int second_position = -1;  ///< address in qpos
  Eigen::Isometry3d T_world_table = Eigen::Isometry3d::Identity();

  /// Whether fingertips sense a geom: one of the table, of the fixture or of an object.
  [[nodiscard]] bool is_sensed(int geom) const;
  /// Whether a geom is of the table or of the fixture.
  [[nodiscard]] bool stands_fast(int geom) const;
};

/// Composes the scene: the options of the solver, the table with the fixture, the hand on its
/// drive or arm and the object: its true surface for the fingertips, convex parts for all
/// else. Gravity is along the table's normal.
/// @param surface  of the object, in its frame; must outlive the scene
/// @throws BadInput for options that are not positive, or if the hand or the object cannot be used
Scene compose_scene(const hand::Description& hand, const SolidObject& solid,
                    const geometry::CapsuleCollider& surface, const WorldOptions& options,
                    const Surroundings& surroundings = {});

}  // namespace palpate::simulation
