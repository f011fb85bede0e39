// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "palpate/registration/registration.hpp"

namespace palpate::registration {

/// Puts what the final solve found into the result, with every pair's distance at its pose. Where a
/// motion is free there is no pose.
void report_final_solve(const PoseEstimate& estimate, const Correspondences& correspondences,
                        Primitive primitive, const AllowedTurns& turns, RegistrationResult& result);

/// Looks for the further poses that are asked for, each a consensus among what the ones before
/// leave over.
void find_more(const Correspondences& correspondences, const RegistrationOptions& options,
               RegistrationResult& result);

/// Puts what no pose can exceed into the certificate of a result that has one, if it is asked for.
void bound_robustly(const Correspondences& correspondences, const RegistrationOptions& options,
                    RegistrationResult& result);

}  // namespace palpate::registration
