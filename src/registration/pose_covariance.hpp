// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "palpate/registration/registration.hpp"

namespace palpate::registration {

/// Covariance of the pose that solves for the inliers with their weights, of twists [w; v] in the
/// target frame; infinite where the residuals are too few.
///
/// Residuals are taken to be independent and normal with one variance, whatever their weights:
/// I^-1 (sum w^2 J'J) I^-1 times the variance, I = sum w J'J, which is the inverse information
/// where all weights are equal. Wrong pairs near the bound, uniform in its ball, leave and join the
/// inliers as the pose moves, which on average undoes their pull: of the information only the right
/// ones' share counts.
/// @param result  its inliers, weights, cost and false inliers
Matrix6d pose_covariance(const PoseEstimate& estimate, const Correspondences& correspondences,
                         Primitive primitive, const AllowedTurns& turns,
                         const RegistrationResult& result);

}  // namespace palpate::registration
