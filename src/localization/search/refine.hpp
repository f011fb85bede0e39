// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <vector>

#include "localization/likelihood/evidence_term.hpp"

namespace palpate::localization {

/// The energy at each of a falling sequence of noise scales, the last of them 1.
using EnergyLadder = std::vector<std::pair<double, Energy>>;
EnergyLadder energy_ladder(const std::function<Energy(double)>& energy_at, double first_scale);

struct RefinedPose {
  SearchPose pose;
  float energy = 0;                         ///< at scale 1
  Matrix6d information = Matrix6d::Zero();  ///< of [rotation; translation] there
  double log_weight = 0;                    ///< Laplace's: -E - ln det(information) / 2
};

/// Descends from a pose by Levenberg-Marquardt steps, the noise shrinking to its true size.
RefinedPose refined(const SearchPose& start, const EnergyLadder& ladder);

/// Covariance of a refined pose; directions that the evidence leaves open are held by
/// `kWeakestRotation` and `kWeakestTranslation`.
Matrix6d covariance_of(const RefinedPose& refined);

/// Directions of a refined pose that the evidence leaves open: it adds less there than the prior
/// that holds them.
int open_directions(const RefinedPose& refined);

}  // namespace palpate::localization
