// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "palpate/registration/registration.hpp"

namespace palpate::registration {

/// Puts what the final solve found into the result, with every pair's distance at its pose. Where a
/// motion is free there is no pose.
void report_final_solve(const PoseEstimate& estimate, const Correspondences& correspondences,
                        Primitive primitive, const AllowedTurns& turns, RegistrationResult& result);

}  // namespace palpate::registration
