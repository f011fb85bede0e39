// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "palpate/tactile/biotac/electrodes.hpp"

namespace palpate::tactile {

/// At most `count` of the samples, chosen at random.
std::vector<BiotacSample> chosen_samples(std::vector<BiotacSample> samples, int count,
                                         std::uint64_t seed);

/// Standard deviation of each electrode's change, counts, at least 1.
ElectrodeChanges electrode_deviation(const std::vector<BiotacSample>& samples);

}  // namespace palpate::tactile
