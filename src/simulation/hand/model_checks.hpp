// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <mujoco/mujoco.h>

#include <string>
#include <vector>

namespace palpate::simulation {

/// @throws BadInput for a link of negative mass
void check_masses(const mjModel& model);

/// @throws BadInput where a constraint ties two links to one another
void refuse_closed_loops(const mjModel& model);

/// Names of the model's tendons.
std::vector<std::string> tendons(const mjModel& model);

}  // namespace palpate::simulation
