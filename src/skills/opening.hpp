// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "palpate/skills/executor.hpp"

namespace palpate::skills {

/// The posture at which the actuators that press would press no more, rad.
hand::ActuatorVector unloaded(const Executor& robot);

/// The fingers' command with those that close as far open as before a grasp from above, rad. What
/// does not close stays: the thumb remains opposed, and sweeps nothing aside.
hand::ActuatorVector opened(const Executor& robot);

/// Opens the fingers. The hand rises a little wherever a fingertip or the table pushes against it
/// meanwhile.
/// @param posture  rad, of all actuators
void open_yielding(Executor& robot, const hand::ActuatorVector& posture, double seconds);

/// Gives back what the fingers press with, and opens them so.
void open_yielding(Executor& robot);

}  // namespace palpate::skills
