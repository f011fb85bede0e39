// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "palpate/tactile/biotac/normal.hpp"

namespace palpate::tactile {

struct BiotacFold {
  std::vector<BiotacSample> training, test;
  /// The test samples with causal rest values; fewer where these are not known.
  std::vector<BiotacSample> test_causal = {};
};

/// Cuts logs where contact breaks; every fold leaves a run of whole touches out. Folds with too few
/// samples to learn from are dropped.
std::vector<BiotacFold> folds_of_touches(const std::vector<BiotacLog>& logs, int folds);

}  // namespace palpate::tactile
