// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "palpate/localization/evidence.hpp"

namespace palpate::localization {

/// A hypothesis about what is stated of all contacts together: noise and size of the object.
struct Hypothesis {
  double point_noise = 1, normal_noise = 1;  ///< relative to the stated one
  double growth = 0;                         ///< of the object, relative to its mesh
  double share = 1;                          ///< prior probability
};

inline constexpr int kMaxNoiseHypotheses = 12;

/// As stated first, then other noise and other sizes; the shares sum to 1. Where contacts share
/// offsets, which each hypothesis has to fit again, only the noise stated and twice as much.
std::vector<Hypothesis> hypotheses(const Evidence& evidence);

}  // namespace palpate::localization
