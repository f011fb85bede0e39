// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <string_view>
#include <vector>

#include "geometry/collider_meshes.hpp"
#include "hand/descriptions.hpp"
#include "palpate/geometry/objects/known_object.hpp"
#include "palpate/hand/hand.hpp"
#include "palpate/hand/shadow.hpp"
#include "palpate/simulation/world/world.hpp"

namespace palpate::simulation {

inline geometry::TriangleMesh cuboid_mesh(const Eigen::Vector3d& size) {
  geometry::TriangleMesh mesh;
  for (int i = 0; i < 8; ++i) {
    const Eigen::Vector3d corner(i & 1, (i >> 1) & 1, i >> 2);
    mesh.vertices.push_back((corner.array() - 0.5) * size.array());
  }
  mesh.triangles = {{0, 2, 3}, {0, 3, 1}, {4, 5, 7}, {4, 7, 6}, {0, 1, 5}, {0, 5, 4},
                    {2, 6, 7}, {2, 7, 3}, {0, 4, 6}, {0, 6, 2}, {1, 3, 7}, {1, 7, 5}};
  return mesh;
}

/// Prism of an outline (m) that is star-shaped about its first corner, counter-clockwise, from z =
/// 0 to `height` (m).
inline geometry::TriangleMesh prism(const std::vector<Eigen::Vector2d>& outline, double height) {
  geometry::TriangleMesh mesh = geometry::prism(outline, height);
  for (Eigen::Vector3d& p : mesh.vertices) p.z() += 0.5 * height;
  return mesh;
}

/// A cuboid of the given size (m) and mass (kg) that stands on its -z face.
inline geometry::KnownObject cuboid(const Eigen::Vector3d& size, double mass) {
  geometry::KnownObject object;
  object.name = "cuboid";
  object.mesh = cuboid_mesh(size);
  object.mass = mass;
  const Eigen::Array3d s = size.array().square();
  const Eigen::Vector3d moments(s[1] + s[2], s[0] + s[2], s[0] + s[1]);
  object.mass_properties.volume = size.prod();
  object.mass_properties.inertia = (mass / 12 * moments).asDiagonal();
  object.stable_poses = {{Eigen::Matrix3d::Identity(), 0.5 * size.z(), 1.0}};
  return object;
}

/// A broad block that pressing hands do not tip over.
inline geometry::KnownObject block() { return cuboid({0.2, 0.2, 0.06}, 1.0); }

/// The block with a round trough along its top, 15 mm deep, whose convex parts are not exact.
inline geometry::KnownObject trough() {
  std::vector<Eigen::Vector2d> outline = {{0, -0.03}, {0.1, -0.03}, {0.1, 0.03}};
  for (int i = -8; i <= 8; ++i) {
    const double x = -0.08 * i / 8.0;
    outline.emplace_back(x, 0.03 - 0.015 * (1 - x * x / (0.08 * 0.08)));
  }
  outline.emplace_back(-0.1, 0.03);
  outline.emplace_back(-0.1, -0.03);
  geometry::KnownObject object = block();
  Eigen::Isometry3d upright = Eigen::Isometry3d::Identity();
  upright.linear() << 1, 0, 0, 0, 0, -1, 0, 1, 0;
  upright.translation().y() = 0.1;
  object.mesh = geometry::transformed(upright, prism(outline, 0.2));
  return object;
}

inline WorldOptions without_noise() {
  WorldOptions options;
  options.noise = {.point = 0, .normal = 0, .force = 0, .joint = 0, .link = 0, .load = 0};
  return options;
}

/// Open hand, palm down, its mount at the given height (m).
inline hand::HandCommand open_hand(double z) {
  hand::HandCommand command = hand::resting_command();
  command.mount.xyz.z() = z;
  return command;
}

/// Palm down, fingers bent at the knuckles so that their tips point down.
inline hand::HandCommand fingers_down(double z) {
  hand::HandCommand command = open_hand(z);
  for (std::string_view joint : {"FFJ3", "MFJ3", "RFJ3", "LFJ3"}) {
    command.positions[hand::shadow_hand().actuator(joint)] = 1.3;
  }
  return command;
}

/// Lowers the fingertips onto the object by `depth` (m) and returns the last reading.
inline hand::HandReading press_block(World& world, int ticks = 100, double depth = 0.03) {
  constexpr double kStart = 0.12;  // m
  world.reset({}, fingers_down(kStart));
  hand::HandReading reading;
  for (int tick = 0; tick < ticks; ++tick) {
    const double way = std::min(1.0, tick / (0.6 * ticks));
    reading = world.hand().step(fingers_down(kStart - way * depth));
  }
  return reading;
}

}  // namespace palpate::simulation
