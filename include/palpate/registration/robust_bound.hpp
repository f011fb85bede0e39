// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "palpate/registration/correspondences.hpp"

namespace palpate::registration {

struct RobustBoundOptions {
  int max_nodes = 0;       ///< subproblems of branch and bound; 0: no bound
  double max_seconds = 1;  ///< stops before max_nodes; the bound then depends on the machine
  int max_pairs = 5000;    ///< more are not bounded: memory and time grow with their square

  template <class Visitor>
  void visit(Visitor&& v) {
    v("max_nodes", max_nodes, 0, 1000000000,
      "subproblems of the bound on the number of inliers of any pose; 0: no bound");
    v("max_seconds", max_seconds, 0.0, 1e6, "time limit of that bound, s");
    v("max_pairs", max_pairs, 3, 100000, "pairs up to which that bound is looked for");
  }
};

/// What no rigid motion can exceed, whatever it is.
struct RobustBound {
  int max_inliers = 0;        ///< no pose has more pairs within the noise bound
  double min_cost = 0;        ///< no pose has a smaller sum of min(r^2, c^2), m^2
  double cost = 0;            ///< that sum of the answer, m^2: the least is between the two
  bool is_exhausted = false;  ///< the search for cliques ran to its end
  int nodes = 0;              ///< subproblems looked at
  double seconds = 0;
};

/// Bounds the number of inliers of every rigid motion by branch and bound, on cliques and over
/// rotations.
///
/// Two inliers of one pose keep their distance to within twice the noise bound c, so that the
/// inliers of any pose are a clique of the graph of such pairs (Parra Bustos et al., ICCV 2019).
/// Cliques are bounded by cores and colourings and searched above `inliers` alone (Tomita & Kameda
/// 2007). Where larger ones are left, branch and bound over SO(3) proves pair by pair that it is an
/// inlier of no pose with more than `inliers` (guaranteed outlier removal, Parra Bustos & Chin,
/// PAMI 2018), and the others' cliques are bounded again. Both relax the bound c to 2 c: the answer
/// is an interval [inliers, max_inliers], which need not close.
/// @param noise_bound  c, m, > 0
/// @param inliers  of the best pose known: the bound is never less
/// @throws BadInput as check(), and for a noise bound that is not positive
RobustBound bound_inliers(const Correspondences& correspondences, double noise_bound, int inliers,
                          const RobustBoundOptions& options);

}  // namespace palpate::registration
