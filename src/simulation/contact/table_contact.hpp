// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>

#include "simulation/world/mujoco_handles.hpp"

namespace palpate::simulation {

/// Index of the user data by which the geoms below are known.
inline constexpr int kHullContactUserData = 1;

/// Geoms of one mesh that share the contacts of a body with a plane: the simulator has room for
/// four contacts between a plane and a mesh, which is too few for a round foot.
inline constexpr int kRestingGeoms = 3;

/// Makes planes meet the geoms' convex hull, which is the same for all of them, in every vertex
/// that reaches the plane, or, of many, in those that bear the body when it leans a little to any
/// side. Other models and geoms are left alone. Threads may call it at once.
///
/// The simulator's own function takes the lowest vertex and up to three of its neighbours. On a
/// finely tessellated hull these lie within millimetres of one another and change from step to
/// step, so that a body resting on far points is borne by one of its ends at a time, and walks.
void use_hull_vertices(mjModel& model, const std::array<int, kRestingGeoms>& geoms);

}  // namespace palpate::simulation
