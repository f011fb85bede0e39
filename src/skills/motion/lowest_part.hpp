// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>

#include "palpate/hand/hand.hpp"
#include "palpate/hand/kinematics.hpp"

namespace palpate::skills {

/// Pitch and roll of the mount.
hand::Attitude attitude_of(const hand::MountPosition& mount);

/// Height of the hand's lowest part over the mount's, m; negative for what is below it.
/// @param counts  which links to look at; empty: all
double lowest_part(const hand::Description& hand, const hand::ActuatorVector& posture,
                   const hand::Attitude& attitude,
                   const std::function<bool(int link)>& counts = {});

/// m by which the fingers of the flat hand hang below the link that is highest: an object may stand
/// between them, its top that much higher than where they stop.
double hollow_depth(const hand::Description& hand);

/// As lowest_part() on the way between two postures and attitudes: what swings is lowest in
/// between.
double lowest_on_way(const hand::Description& hand, const hand::ActuatorVector& from,
                     const hand::Attitude& from_attitude, const hand::ActuatorVector& to,
                     const hand::Attitude& to_attitude);

}  // namespace palpate::skills
