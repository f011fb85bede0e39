// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "palpate/hand/hand.hpp"
#include "palpate/skills/safety.hpp"

namespace palpate::skills {

/// The next command of a hand that has been stopped: the base approaches the place where it was
/// measured, so that it pushes no more, and no finger presses harder than
/// SafetyOptions::rest_torque.
hand::HandCommand eased(const hand::HandCommand& command, const hand::HandReading& reading,
                        const hand::Description& hand, const SafetyOptions& options);

}  // namespace palpate::skills
