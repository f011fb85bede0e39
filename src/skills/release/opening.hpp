// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "palpate/skills/release/set_down_phase.hpp"

// The two ways in which the hand opens around an object. In both the hand rises a little wherever a
// fingertip or the table pushes against it meanwhile.
namespace palpate::skills {

/// Opens the fingers where they are, standing object or not: as far as before a grasp from above.
/// What does not close stays: the thumb remains opposed, and sweeps nothing aside.
void open_yielding(Executor& robot);

/// Lets go of an object that stands on the table: records the event `placed`, takes the squeeze
/// back as it came, then opens slowly.
void release(Executor& robot, const LowerOptions& options);

}  // namespace palpate::skills
