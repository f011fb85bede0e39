// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "palpate/core/random.hpp"
#include "palpate/core/statistics.hpp"

namespace palpate::numerics {

/// Mean of what is left without the lowest and the highest quarter of the values, both rounded
/// down: of three values it is their mean. @throws BadInput for no values
double interquartile_mean(std::vector<double> values);

/// Scores of several trainings, apart by stratum (a task, a condition), as in strata[s][training].
using Strata = std::vector<std::vector<double>>;

/// 95 % confidence interval of the interquartile mean over all strata: percentiles of resamples
/// that draw trainings with replacement within each stratum (Agarwal et al. 2021).
/// @throws BadInput for no strata, or one without values
Interval bootstrap_interquartile_mean(const Strata& strata, int resamples, RandomStream random);

}  // namespace palpate::numerics
