// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "sliding_finger.hpp"

namespace palpate::experiment {

/// A surface of the thesis (figures 5.4, 5.5) and a finger's way over it.
struct TouchedSurface {
  std::string name;  ///< flat, edge, smooth or corner
  geometry::KnownObject object;
  simulation::Start start;
  std::vector<Eigen::Vector3d> faces;  ///< normals of those that the way crosses, world
};

TouchedSurface touched_surface(const std::string& name);

inline constexpr double kPress = 2;  ///< N, with which the finger presses

/// The world in which a finger slides: readers' noise as everywhere, fingers stiff enough to be led
/// over edges.
simulation::WorldOptions sliding_world();

/// The way of a fingertip of that radius (m) over the surface, at about 20 mm/s: a Lissajous figure
/// on the flat and the smooth surface; over the edge and back every 8 s; on the corner over the
/// other two edges too.
TipPath path_over(const TouchedSurface& surface, double tip_radius, double seconds);

}  // namespace palpate::experiment
