// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Geometry>
#include <array>
#include <span>

#include "palpate/estimation/event_log.hpp"
#include "palpate/hand/kinematics.hpp"
#include "palpate/tactile/contacts/contact_window.hpp"

namespace palpate::estimation {

using Fingers = hand::PerFinger<bool>;

/// The readings of the last `seconds` up to one of them, with it.
std::span<const hand::HandReading> window_before(const EventLog& log, std::size_t index,
                                                 double seconds);

/// How the object has moved in the hand's base between two readings. Contacts roll along the
/// fingertips while they carry it, so that the way is followed step by step.
/// @param ignored  fingers that do not hold it
Eigen::Isometry3d in_hand_motion(const hand::Description& hand, const EventLog& log,
                                 std::size_t first, std::size_t last,
                                 const tactile::ContactErrorModel& errors,
                                 const Fingers& ignored = {});

}  // namespace palpate::estimation
