// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "simulation/world/mujoco_handles.hpp"

namespace palpate::simulation {

/// A joint that follows another: angle = offset + ratio * leader. One that is locked follows any,
/// with the ratio 0.
struct MimicJoint {
  std::string joint, leader;
  double ratio = 1, offset = 0;  ///< offset in rad
};

/// Whether an active equality keeps the length of this fixed tendon of two joints, so that one of
/// them follows the other.
bool ties_joints(const mjModel& model, int tendon);

/// The joints that follow others: by the model's equalities, or by a URDF's mimic tags. Of joints
/// that equalities tie, the one with an actuator leads, whichever way they are written.
/// @throws BadInput for joints that follow one another in a circle, or a leader that is not there
std::vector<MimicJoint> mimic_joints(const mjModel& model, const std::filesystem::path& file);

}  // namespace palpate::simulation
