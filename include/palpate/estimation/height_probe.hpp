// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "palpate/hand/hand.hpp"
#include "palpate/hand/kinematics.hpp"

namespace palpate::estimation {

/// Height above the table of the lowest part of the hand, in a reading, m.
double lowest_of_hand(const hand::Description& model, const hand::HandReading& reading);

/// Place on the table under the middle of the flat hand, in a reading, m.
Eigen::Vector2d place_under_hand(const hand::Description& model, const hand::HandReading& reading);

}  // namespace palpate::estimation
