// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "palpate/localization/evidence.hpp"
#include "palpate/localization/posterior.hpp"

namespace palpate::localization {

/// What an earlier posterior says of the pose after a motion that is known up to a normal error.
///
/// A mode becomes a component; one with a free axis becomes one every 5 deg of its arc, which
/// share its weight. Covariances are the sum of the mode's, the motion's and (0.5 deg)^2, (0.5
/// mm)^2. The spread along a free axis is half the distance of neighbours instead of the mode's,
/// which makes the density along it even. The poses of the residual set become components that
/// share what the modes lack of the credible mass. What is left, 0.05 or more, is the floor's
/// (spread_elsewhere()).
/// @param motion_covariance  of [rotation; translation] (rad, m), frame's axes; may be zero
/// @throws BadInput when there are no modes or the motion's is not a covariance
PosePrior prior_from(const Posterior& posterior, const Matrix6d& motion_covariance);

/// The same of the modes alone, with the default floor: for who knows better what is elsewhere.
PosePrior prior_from_modes(const Posterior& posterior, const Matrix6d& motion_covariance);

/// Adds the components of another prior, heaviest first, with their weights times `share`.
void append(const PosePrior& part, double share, PosePrior& prior);

/// Sets the floor to the density of a probability that is spread evenly over all rotations and one
/// cubic decimetre, relative to the peak, at most 0.5: what touch can overrule does not depend on
/// how narrow the prior is.
/// @param elsewhere  that probability
void spread_elsewhere(double elsewhere, PosePrior& prior);

}  // namespace palpate::localization
