// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "palpate/hand/kinematics.hpp"
#include "palpate/hand/shadow.hpp"
#include "palpate/planning/planner.hpp"
#include "palpate/simulation/collision/collision_scene.hpp"
#include "palpate/simulation/hand/load_hand.hpp"

namespace palpate::planning {

/// An upright plate (m) to go around, in its own frame.
inline geometry::KnownObject plate() {
  const Eigen::Vector3d size(0.2, 0.04, 0.16);
  geometry::KnownObject object;
  object.name = "plate";
  for (int i = 0; i < 8; ++i) {
    const Eigen::Vector3d corner(i & 1, (i >> 1) & 1, i >> 2);
    object.mesh.vertices.push_back((corner.array() - 0.5) * size.array());
  }
  object.mesh.triangles = {{0, 2, 3}, {0, 3, 1}, {4, 5, 7}, {4, 7, 6}, {0, 1, 5}, {0, 5, 4},
                           {2, 6, 7}, {2, 7, 3}, {0, 4, 6}, {0, 6, 2}, {1, 3, 7}, {1, 7, 5}};
  object.mass = 0.4;
  object.mass_properties.volume = size.prod();
  object.mass_properties.inertia = 1e-3 * Eigen::Matrix3d::Identity();
  return object;
}

/// The drawn hand.
inline const hand::Description& drawn_hand() {
  static const hand::Description hand = simulation::load_hand("shadow");
  return hand;
}

inline Eigen::Isometry3d at(double x, double y, double z) {
  return Eigen::Isometry3d(Eigen::Translation3d(x, y, z));
}

/// Open hand, palm down.
inline Waypoint open_hand(double x, double y, double z) {
  Waypoint waypoint;
  waypoint.joints.setZero(hand::kShadowJoints);
  waypoint.mount.xyz << x, y, z;
  return waypoint;
}

inline double& joint(Waypoint& waypoint, std::string_view name) {
  return waypoint.joints[hand::shadow_hand().joint(name)];
}

inline bool is_free(simulation::CollisionScene& scene, const hand::HandCommand& command) {
  return !scene.deepest_collision(command.mount,
                                  hand::joints_in_free_flexion(scene.hand(), command.positions));
}

/// The samples as rows.
inline std::vector<Coordinates> coordinates(const std::vector<hand::HandCommand>& samples) {
  std::vector<Coordinates> result;
  for (const hand::HandCommand& sample : samples) result.push_back(coordinates_of(sample));
  return result;
}

}  // namespace palpate::planning
