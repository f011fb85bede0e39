// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "palpate/hand/hand.hpp"

namespace palpate::hand {

/// Number of fingertip contacts pressed harder than `least` (N).
int count_contacts(const HandReading& reading, double least = 0.1);

/// Number of fingers with a contact, however light.
int touching_fingers(const HandReading& reading);

/// Normal force of the hardest pressed contact of a finger, N; the whole force of a contact without
/// a normal.
double tip_force(const HandReading& reading, int finger);

/// m from a fingertip's surface within which its contacts are: amply, for models are not exact.
inline constexpr double kTipReach = 0.1;

/// m of a point in the fingertip's link from the capsule of its tip; 0 within it, and for a finger
/// whose link is not known.
double distance_from_tip(const Eigen::Vector3d& p, const Finger& finger);

}  // namespace palpate::hand
