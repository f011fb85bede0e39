// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "registration/consensus.hpp"

namespace palpate::registration {

/// Inliers among all pairs, ascending, that inliers and least squares in turn lead to from T.
std::vector<int> settle(const Correspondences& correspondences, Eigen::Isometry3d T,
                        const ConsensusOptions& options);

}  // namespace palpate::registration
