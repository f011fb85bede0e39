// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "palpate/hand/kinematics.hpp"

namespace palpate::hand {

/// Whether a hand can take a posture without its fingers pressing on one another or on the palm:
/// no links come near each other that do not in a posture which it can take.
bool is_clear_of_itself(const Description& hand, const JointVector& joints,
                        const JointVector& possible);

}  // namespace palpate::hand
