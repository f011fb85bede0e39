// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "palpate/registration/cloud_registration.hpp"

namespace palpate::registration {

/// register_clouds() where the target is also a scaled source.
///
/// Each cloud is sampled to a grid of its own, so that features of both cover like parts of their
/// surfaces; as the clouds may overlap in part only, grids of five ratios are tried. Lengths
/// between matches vote for scales, the one with the clearest consensus is registered as a known
/// scale is, and scale and pose are refined together. kDegenerate where the pairs leave the scale
/// free, as three planes do.
CloudRegistration register_scaled_clouds(const geometry::PointView& source,
                                         const geometry::PointView& target,
                                         const CloudOptions& options);

}  // namespace palpate::registration
