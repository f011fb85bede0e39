// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <mujoco/mujoco.h>

#include "palpate/geometry/mesh/mesh.hpp"

namespace palpate::simulation {

/// A geom's surface in the geom's own frame: its mesh, or a box, sphere, ellipsoid, capsule or
/// cylinder in triangles. Empty for planes and other geoms.
geometry::TriangleMesh geom_mesh(const mjModel& model, int geom);

}  // namespace palpate::simulation
