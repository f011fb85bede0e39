// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "palpate/hand/kinematics.hpp"
#include "palpate/pipeline/touch_log.hpp"

namespace palpate::pipeline {

/// How far the contacts have wandered along the fingertips between two instants of the log, in the
/// median over the fingers that touch at both, m; 0 if there is none.
double contact_drift(const TouchLog& log, const hand::HandModel& hand, std::size_t before,
                     std::size_t after);

}  // namespace palpate::pipeline
