// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <vector>

#include "localization/search/pose_family.hpp"
#include "localization/search/proposal.hpp"
#include "localization/search/refine.hpp"
#include "palpate/core/random.hpp"
#include "palpate/geometry/objects/known_object.hpp"

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
  /// Rotations of the object, in its own frame, by which it may be nearly symmetric.
  std::vector<Eigen::Matrix3d> near_symmetries = {};
};

/// Half turns about the principal axes of inertia: where an object is nearly symmetric, often by
/// one of these.
std::vector<Eigen::Matrix3d> half_turns(const geometry::KnownObject& object);

/// Where the best proposals lead downhill, most probable by Laplace's approximation first; equal
/// poses of a symmetric object are one.
///
/// Further descents start from the images of the most probable ends under the near symmetries. A
/// twin of the right pose fits nearly as well and has a basin of its own, and proposals may lead
/// into the one basin alone.
std::vector<Basin> find_basins(const Proposal& proposal,
                               const std::function<Energy(double)>& energy_at,
                               const PoseFamily::Symmetries& symmetries,
                               const DescentOptions& options, RandomStream& random);

/// Shares of the basins in the mass of all, by Laplace's approximation.
std::vector<double> basin_shares(const std::vector<Basin>& basins);

/// Normal distributions about the basins, from which to draw and weigh: wider than the basins, and
/// the lesser ones drawn from more often than their shares, so that all of the mass is covered.
PosePrior mixture_about(const std::vector<Basin>& basins);

}  // namespace palpate::localization
