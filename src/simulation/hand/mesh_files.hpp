// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

#include "simulation/world/mujoco_handles.hpp"

namespace palpate::simulation {

/// Finds the meshes of a parsed file that the simulator does not: those of package://, model:// and
/// file://, and PLY and STL files of text, which are read here.
/// @throws BadInput, naming the mesh, the link that collides with it, and what to do
void find_meshes(mjSpec& spec, const std::filesystem::path& file);

}  // namespace palpate::simulation
