// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "palpate/hand/kinematics.hpp"
#include "simulation/world/mujoco_handles.hpp"

namespace palpate::simulation {

/// Puts the links of a compiled hand where the believed model has them.
/// @throws BadInput for a link that the compiled hand lacks
void place_links(const hand::Description& believed, mjModel& model);

}  // namespace palpate::simulation
