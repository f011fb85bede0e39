// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "palpate/registration/registration.hpp"

namespace palpate::registration {

/// register_correspondences() where the target is also a scaled source: the ratios of lengths
/// between random pairs vote for a few scales (as in TEASER, Yang et al., T-RO 2021, 5.1, by a
/// histogram), the one with most inliers stays, and scale and pose take turns (Umeyama 1991).
RegistrationResult register_scaled(const Correspondences& correspondences,
                                   const RegistrationOptions& options);

}  // namespace palpate::registration
