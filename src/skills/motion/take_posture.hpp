// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "palpate/skills/executor.hpp"

namespace palpate::skills {

/// Whether fingers would meet one another on the straight way to a posture.
bool fingers_meet(const Executor& robot, const hand::ActuatorVector& posture);

/// Moves the fingers to a posture in the given time (s), each actuator straight on; where fingers
/// would meet one another on the way, by the stretched hand.
void take_posture(Executor& robot, const hand::ActuatorVector& posture, double seconds);

}  // namespace palpate::skills
