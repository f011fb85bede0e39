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
/// which makes the density along it even.
/// @param motion_covariance  of [rotation; translation] (rad, m), frame's axes; may be zero
/// @throws BadInput when there are no modes or the motion's is not a covariance
PosePrior prior_from(const Posterior& posterior, const Matrix6d& motion_covariance);

}  // namespace palpate::localization
