// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "geometry/mesh/convex_hull.hpp"

namespace palpate::geometry {

/// A facet on which the body stays, and the share of random drops that end on it.
struct RestingFacet {
  Eigen::Vector3d normal;  ///< outward: down when the body rests on it
  double height = 0;       ///< of the centroid above the facet, m
  double probability = 0;
  int family = 0;  ///< resting facets of one family are joined by paths below the barrier
};

/// Resting facets of a convex body under quasi-static rolling; those that lie more than `barrier`
/// above the lowest of their family have passed their share on to it.
std::vector<RestingFacet> resting_facets(const std::vector<HullFacet>& hull,
                                         const Eigen::Vector3d& centroid, double barrier);

}  // namespace palpate::geometry
