// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "palpate/simulation/world/world.hpp"
#include "simulation/world/mujoco_handles.hpp"

namespace palpate::simulation {

/// Gives the hand's joints what the maker's MJCF leaves out: the ranges of thesis table A.1, the
/// coupling of J1 and J2 (hand::Coupling), and servos of the wanted stiffness.
/// @throws BadInput if a joint or an actuator is missing
void prepare_joints(mjSpec& spec, const WorldOptions& options);

}  // namespace palpate::simulation
