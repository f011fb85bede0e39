// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "palpate/estimation/estimate.hpp"
#include "palpate/localization/posterior.hpp"

namespace palpate::evaluation {

struct CrediblePose {
  Eigen::Isometry3d T_frame_object = Eigen::Isometry3d::Identity();
  double probability = 0;  ///< share of the posterior mass that it stands for
};

/// A posterior as single poses, for drawing: each mode, some along its free axis if it has one,
/// and the further credible poses.
/// @param most  poses returned at most
/// @return most probable first; poses of less than 0.003 are left out, unless
///         the most probable one has hardly more
std::vector<CrediblePose> credible_poses(const localization::Posterior& posterior,
                                         std::size_t most);

/// Text of the note that a recording has of them: probability and pose of each, row by row.
std::string credible_note(const localization::Posterior& posterior);

/// What is believed before the first touch, drawn: any stable pose with any yaw, near the rough
/// place. Each stands for its ball of 5 deg and 10 mm alone, so that together they have little of
/// the probability.
/// @return in the world
std::vector<CrediblePose> prior_poses(
    const geometry::KnownObject& object, const estimation::EstimationOptions& options,
    const Eigen::Isometry3d& T_world_table = Eigen::Isometry3d::Identity());

}  // namespace palpate::evaluation
