// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <mujoco/mujoco.h>

#include <span>
#include <string>
#include <vector>

#include "palpate/hand/description.hpp"

namespace palpate::simulation {

/// @throws BadInput where an active constraint ties two links to one another
void refuse_closed_loops(const mjModel& model);

/// @throws BadInput where a shape is larger than any hand or arm: the lengths are in millimetres
void check_shapes(const mjModel& model);

/// @throws BadInput where fingertips are where no hand's can be: the lengths are in millimetres
void check_size(const hand::Description& hand);

/// @throws BadInput for limits of a joint that are more than a turn: they may be degrees
void check_limits(const std::string& joint, const hand::Range& range);

/// The first three names, and how many there are more.
std::string first_of(std::span<const std::string> names);

/// That the model's tendons are left out, with the names of the first; empty: it has none.
std::string left_out_tendons(const mjModel& model);

/// How many joints have a spring.
int springs(const mjModel& model);

}  // namespace palpate::simulation
