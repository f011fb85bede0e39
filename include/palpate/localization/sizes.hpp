// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "palpate/geometry/objects/known_object.hpp"
#include "palpate/localization/identification.hpp"

namespace palpate::localization {

/// Candidates, some of which may be one shape in several sizes (geometry::resized()).
using SizedCandidates = std::vector<const geometry::KnownObject*>;

/// Makes `best` the most probable size of the most probable shape, and sums over its sizes.
void choose_shape(const SizedCandidates& candidates, ObjectProbabilities& objects);

/// The posterior of the pose of the best candidate's shape, whatever its size: the modes of all its
/// sizes, those within 5 deg and 10 mm of one another as one, whose covariance holds what they are
/// apart.
/// @param posteriors  of each candidate, its weights times its probability
Posterior pooled(const SizedCandidates& candidates, const ObjectProbabilities& objects,
                 const std::vector<Posterior>& posteriors);

}  // namespace palpate::localization
