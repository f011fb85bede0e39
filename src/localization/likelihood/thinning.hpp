// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "palpate/localization/evidence.hpp"

namespace palpate::localization {

/// The evidence without contacts that repeat one before them, whose errors are the same: digit for
/// digit, or with a point nearer than twice its point_sigma (at most 3 mm) and a normal nearer than
/// twice its normal_sigma, of the same finger and without an offset, as the samples of one resting
/// touch. And with at most 64, spread evenly over their order: more hardly sharpen the pose but
/// cost time in proportion.
Evidence thinned(Evidence evidence);

}  // namespace palpate::localization
