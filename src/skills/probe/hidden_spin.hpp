// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "palpate/geometry/objects/object_model.hpp"
#include "palpate/localization/posterior.hpp"

namespace palpate::skills {

/// Probability of the best pose whatever its spin, where that hardly shows: rotated about the
/// mode's free axis to its ends, the surface is off the original by less than three times its
/// error (root mean square). Another grasp then adds no information, unlike of a mug whose handle
/// has not been found yet.
/// @param surface_sigma  error of the surface, m
double probability_but_for_hidden_spin(const geometry::ObjectModel& object,
                                       const localization::Posterior& posterior,
                                       double surface_sigma);

}  // namespace palpate::skills
