// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "localization/search/pose_family.hpp"

namespace palpate::localization {

/// The share of `poses` that are not within the tolerance of any of `others`: an estimate of
/// the probability that another pose lies elsewhere than all of these.
double unseen_share(const std::vector<PosePoint>& poses, const std::vector<PosePoint>& others,
                    const PoseFamily::Symmetries& symmetries);

struct ResidualSet {
  std::vector<Eigen::Isometry3d> poses;
  double credible_mass = kCredible;  ///< Posterior::credible_mass
};

/// Centres of balls (5 deg, 10 mm) that hold, beside the modes, the credible share of `weighed_on`,
/// those first that hold the most of `chosen_on`. Where all poses of `chosen_on` hold less of the
/// other, independent population than that, balls about the rest of this one follow; the stated
/// mass is then what the modes and the first balls hold.
ResidualSet residual_set(const std::vector<Mode>& modes, const std::vector<PosePoint>& chosen_on,
                         const std::vector<PosePoint>& weighed_on,
                         const PoseFamily::Symmetries& symmetries);

}  // namespace palpate::localization
