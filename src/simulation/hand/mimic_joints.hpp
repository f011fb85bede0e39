// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <vector>

#include "simulation/hand/urdf.hpp"
#include "simulation/world/mujoco_handles.hpp"

namespace palpate::simulation {

/// Whether an active equality keeps the length of this fixed tendon of two joints, so that one of
/// them follows the other.
bool ties_joints(const mjModel& model, int tendon);

/// The joints that follow others: by the model's equalities, or by a URDF's mimic tags. Of joints
/// that equalities tie, the one with an actuator leads, whichever way they are written.
/// @throws BadInput for joints that follow one another in a circle, or a leader that is not there
std::vector<MimicJoint> mimic_joints(const mjModel& model, const std::filesystem::path& file);

}  // namespace palpate::simulation
