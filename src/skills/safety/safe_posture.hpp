// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "palpate/hand/hand.hpp"
#include "palpate/skills/safety.hpp"

namespace palpate::skills {

/// The next command of a hand that has been stopped: the mount approaches the place where it was
/// measured, so that it pushes no more.
hand::HandCommand with_eased_mount(const hand::HandCommand& command,
                                   const hand::HandReading& reading, const SafetyOptions& options);

/// The same for its fingers: none presses harder than SafetyOptions::rest_torque.
hand::HandCommand with_eased_fingers(const hand::HandCommand& command,
                                     const hand::HandReading& reading,
                                     const hand::Description& hand, const SafetyOptions& options);

}  // namespace palpate::skills
