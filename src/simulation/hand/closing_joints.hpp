// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "palpate/hand/description.hpp"

namespace palpate::simulation {

/// Outer end of every fingertip in the mount's frame, m, in free flexion.
std::vector<Eigen::Vector3d> fingertips(const hand::Description& hand,
                                        const hand::ActuatorVector& positions);

/// Whether every finger has an actuator whose range goes mainly one way, by which it closes.
bool ranges_determine_closing(const hand::Description& hand);

/// The joints of fingers whose range does not determine which way they close, in words; empty:
/// none.
std::string symmetric_joints(const hand::Description& hand);

/// Every finger's last actuator closes it, and those before that turn about an axis like its. Of a
/// thumb the last two at most do; those before set it against the fingers. They close the way that
/// their ranges mainly go, or else towards the other fingers.
void derive_closing(hand::Description& hand);

/// Reverses the first joints of a hand that its file draws closed at 0: those of all fingers have
/// ranges that go outwards, away from the fingers on the other side.
/// @return whether it did
bool reverse_if_closed_at_zero(hand::Description& hand);

/// The joints that a user says close the fingers, and no others; "-joint" closes towards its lower
/// limit. @throws BadInput for a name that is no joint, or that no actuator of a finger moves
void set_closing(const std::vector<std::string>& joints, hand::Description& hand);

}  // namespace palpate::simulation
