// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <mujoco/mujoco.h>

#include <string>
#include <utility>
#include <vector>

#include "palpate/hand/description.hpp"

namespace palpate::simulation {

/// Lets all of a hand that collides with anything collide with itself, as in a simulated world.
/// @return whether the file has it otherwise
bool let_all_collide(mjSpec& spec);

/// Pairs of bodies of a hand that overlap by more than 0.5 mm in each of some postures.
std::vector<std::pair<std::string, std::string>> overlapping_links(
    const mjModel& model, const hand::Description& hand,
    const std::vector<hand::JointVector>& postures);

/// The first three pairs in words, and how many there are more.
std::string first_of(const std::vector<std::pair<std::string, std::string>>& pairs);

}  // namespace palpate::simulation
