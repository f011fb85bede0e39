// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "palpate/hand/description.hpp"
#include "simulation/world/mujoco_handles.hpp"

namespace palpate::simulation {

/// Gives the hand's joints in a parsed model what is known of them beside the file: their ranges,
/// the coupling of pairs, and position servos.
/// @param stiffness_scale  of the file's own servos, where the hand keeps them
/// @throws BadInput if a joint or an actuator is missing
void prepare_joints(mjSpec& spec, const hand::Description& hand, double stiffness_scale);

}  // namespace palpate::simulation
