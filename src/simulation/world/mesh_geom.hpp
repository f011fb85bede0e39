// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <mujoco/mujoco.h>

#include <string>

#include "palpate/geometry/mesh/mesh.hpp"

namespace palpate::simulation {

/// Adds a mesh (m, in the body's frame) under a new name, and a geom of that name with it.
mjsGeom& add_mesh(mjSpec& spec, mjsBody& body, const std::string& name,
                  const geometry::TriangleMesh& mesh);

}  // namespace palpate::simulation
