// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "palpate/hand/hand.hpp"
#include "palpate/hand/kinematics.hpp"

namespace palpate::estimation {

/// Middle of the level underside of the flat hand, in the horizontal axes of its base, m.
inline const Eigen::Vector2d kLevelCenter(0.072, -0.005);

/// Height above the table of the lowest part of the hand, in a reading, m.
double lowest_of_hand(const hand::HandModel& model, const hand::HandReading& reading);

/// Place on the table under the middle of the flat hand, in a reading, m.
Eigen::Vector2d place_under_hand(const hand::HandReading& reading);

}  // namespace palpate::estimation
