// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "palpate/estimation/event_log.hpp"
#include "palpate/hand/kinematics.hpp"

namespace palpate::estimation {

/// How far the contacts have wandered along the fingertips between two instants of the log, in the
/// median over the fingers that touch at both, m; 0 if there is none.
double contact_slip(const EventLog& log, const hand::Description& hand, std::size_t before,
                    std::size_t after);

}  // namespace palpate::estimation
