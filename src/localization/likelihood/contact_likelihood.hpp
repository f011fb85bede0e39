// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "localization/likelihood/contact_noise.hpp"

namespace palpate::localization {

inline constexpr float kOutlierVariance = 9;  // times the variance of normals, there

/// Where a contact lies at a pose.
struct ContactPlace {
  float distance = 0, normal = 0;  // from the surface it is compared at; 1 - cosine of the normals
  float scale_derivative = 0;      // of `distance` by the object's growth
  float squared_curvature = 0;     // of the surface, 1/m^2
};

/// Likelihood of a contact under each of kMaxNoiseHypotheses hypotheses, relative to its peak:
/// ContactTerm::likelihood() where there are as many, bit for bit, but sooner.
NoiseArray likelihood_at_all(const NoiseLevels& noise, const NoiseArray& growth,
                             const ContactPlace& place);

}  // namespace palpate::localization
