// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "palpate/registration/registration.hpp"

namespace palpate::registration {

/// Puts what the final solve found into the result, with every pair's distance at its pose.
void fill_in(const PoseEstimate& estimate, const Correspondences& correspondences,
             RegistrationResult& result);

}  // namespace palpate::registration
