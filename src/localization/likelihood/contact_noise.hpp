// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <vector>

#include "localization/likelihood/hypothesis.hpp"
#include "palpate/geometry/objects/object_model.hpp"
#include "palpate/localization/evidence.hpp"

namespace palpate::localization {

/// Standard deviation of a contact's normal, rad; infinite where there is none.
double normal_sigma_of(const tactile::Contact& contact);

/// Density (per m and sr) of a true contact's distance and normal at its peak, the contact lying
/// anywhere on the surface (per m^2).
/// @param normal_sigma  rad; infinite: a normal in any direction
double peak_contact_density(double area, double point_sigma, double normal_sigma);

/// One value for each hypothesis, the first being that all is as stated.
using NoiseArray = Eigen::Array<float, Eigen::Dynamic, 1, 0, kMaxNoiseHypotheses, 1>;
/// The noise of a contact at each level.
struct NoiseLevels {
  NoiseArray half_point_precision, normal_precision;
  NoiseArray curvature_widening;  // sp^2 / sn^2, m^2
  NoiseArray odds;                // A
  float min_half_point_precision = 0, min_normal_precision = 0, max_curvature_widening = 0;
  float cap = 0, inverse_peak = 0;  // the greatest ln(1 + A), 1 / (1 + A)
  float stated_cap = 0;             // ln(1 + A) of the first
  float outlier_share = 0;          // of normals
  bool last_as_first = false;       // the last four have the first's noise: they are other sizes
};

/// @param scale  by which all noise is multiplied
NoiseLevels make_noise(const geometry::ObjectModel& model, const Evidence& evidence,
                       const tactile::Contact& contact, const std::vector<Hypothesis>& levels,
                       double scale);

}  // namespace palpate::localization
