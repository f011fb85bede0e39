// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "palpate/hand/arm.hpp"
#include "palpate/hand/description.hpp"
#include "simulation/world/mujoco_handles.hpp"

namespace palpate::simulation {

inline constexpr const char* kArmPrefix = "arm_";  ///< of all names of the arm's file

/// The model of an arm on its stand, with the hand fixed to its flange. The arm's weight is carried
/// by its drives; its joints follow their commands as late as a floating mount does.
/// @param hand_spec  the hand's model; keeps what the other needs, and must outlive it
SpecHandle arm_with_hand(const hand::ArmDescription& arm, const hand::Description& hand,
                         const mjSpec& hand_spec);

}  // namespace palpate::simulation
