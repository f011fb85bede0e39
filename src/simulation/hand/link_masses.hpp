// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "simulation/world/mujoco_handles.hpp"

namespace palpate::simulation {

constexpr double kLeastMass = 1e-3;  ///< kg, of a link that moves and that the file gives none

/// Rules for inertias of the file's own bodies are applied, so that they do not reach what is
/// added.
void apply_inertia_rules(mjSpec& spec);

/// @throws BadInput for a link or shape of negative mass
void refuse_negative_masses(mjSpec& spec);

/// Gives a little mass to links that move without any, as those between joints of one place.
/// @return their names
std::vector<std::string> give_masses(mjSpec& spec);

}  // namespace palpate::simulation
