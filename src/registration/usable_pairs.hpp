// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "palpate/core/random.hpp"
#include "palpate/registration/correspondences.hpp"

namespace palpate::registration {

/// Correspondences that the search looks at; the final inliers come from all. Those of weight 0 are
/// left out, and those so far from the others that single precision would lose these. Of many a
/// random share, by weight: an order in the list must not matter.
Correspondences search_sample(const Correspondences& correspondences, double noise_bound,
                              const RandomStream& random);

}  // namespace palpate::registration
