// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <vector>

#include "localization/search/pose_family.hpp"
#include "localization/search/proposal.hpp"
#include "localization/search/refine.hpp"
#include "palpate/core/random.hpp"

namespace palpate::localization {

/// A pose that one or more descents ended at.
struct Basin {
  RefinedPose best;
  PosePoint pose;
  int starts = 1;
};

struct DescentOptions {
  int proposals;       ///< poses screened
  int starts;          ///< the best of these, which are refined
  double first_scale;  ///< of the noise, where screening and refining begin
};

/// Where the best proposals lead downhill, most probable by Laplace's approximation first; equal
/// poses of a symmetric object are one.
std::vector<Basin> find_basins(const Proposal& proposal,
                               const std::function<Energy(double)>& energy_at,
                               const PoseFamily::Symmetries& symmetries,
                               const DescentOptions& options, RandomStream& random);

/// Shares of the basins in the mass of all, by Laplace's approximation.
std::vector<double> basin_shares(const std::vector<Basin>& basins);

}  // namespace palpate::localization
