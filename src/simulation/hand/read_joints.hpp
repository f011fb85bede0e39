// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "palpate/simulation/hand/describe_hand.hpp"
#include "simulation/hand/anatomy.hpp"

namespace palpate::simulation {

constexpr double kLeastBend = 0.1;  ///< rad: ranges below that are suspicious

/// Adds the joints below the hand's root, with their ranges: the file's, else that of an actuator's
/// commands, else a usual one, which is reported.
/// @return their ids in the model
/// @throws BadInput for limits beyond a turn, and for no joints or too many
std::vector<int> read_joints(const mjModel& model, const Anatomy& anatomy, DescribedHand& result);

}  // namespace palpate::simulation
