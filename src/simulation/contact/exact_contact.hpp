// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "palpate/geometry/query/capsule_collider.hpp"
#include "simulation/world/mujoco_handles.hpp"

namespace palpate::simulation {

/// Numbers a geom's user data must hold for its exact surface.
inline constexpr int kExactContactUserData = 1;

/// Makes the solver meet capsules with the collider's surface, in the frame of the geom's body,
/// instead of with the convex hull of the mesh geom. Other models and geoms are left alone. The
/// collider must outlive the model. Threads may call it at once.
///
/// The simulator finds its collision functions in a table of the process; the first call replaces
/// the entry for capsules and meshes by one that looks for the collider in the geom's user data.
void use_exact_surface(mjModel& model, int geom, const geometry::CapsuleCollider& collider);

/// Index of the user data that a fingertip's hull is kept in.
inline constexpr int kTipHullUserData = 2;

/// Makes the solver meet exact surfaces, and planes, with the rounded hull in the frame of the
/// geom's body instead of with the mesh geom. The hull must outlive the model.
void use_tip_hull(mjModel& model, int geom, const geometry::RoundedHull& hull);

/// Null for a geom without.
const geometry::RoundedHull* tip_hull_of(const mjModel& model, int geom);

}  // namespace palpate::simulation
