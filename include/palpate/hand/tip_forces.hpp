// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "palpate/hand/hand.hpp"

namespace palpate::hand {

/// Number of fingertip contacts pressed harder than `least` (N).
int count_contacts(const HandReading& reading, double least = 0.1);

/// Number of fingers with a contact, however light.
int touching_fingers(const HandReading& reading);

/// Normal force of the hardest pressed contact of a finger, N.
double tip_force(const HandReading& reading, int finger);

}  // namespace palpate::hand
