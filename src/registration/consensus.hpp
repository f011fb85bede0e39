// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "palpate/core/random.hpp"
#include "palpate/registration/correspondences.hpp"

namespace palpate::registration {

class Scorer;

struct ConsensusOptions {
  double noise_bound = 0.004;   ///< m
  double normal_noise_deg = 0;  ///< per tangent axis; 0: without normals
  double false_alarm = 0.01;    ///< poses that chance may propose per problem
};

struct Consensus {
  Eigen::Isometry3d T_target_source = Eigen::Isometry3d::Identity();
  bool found = false;             ///< chance does not explain it
  double expected_by_chance = 0;  ///< poses as good as this one among wrong correspondences alone
  int hypotheses = 0;             ///< cliques tried
};

/// Pose that gathers the largest truncated gain over all correspondences: cliques of the
/// consistency graph, each grown in the neighbourhood (star) of one correspondence of a growing
/// sample, propose poses, which are refined on all correspondences, until one is too good for
/// chance or a larger consensus would have come up.
Consensus find_consensus(const Correspondences& correspondences, const ConsensusOptions& options,
                         const RandomStream& random);

/// How many poses as good as T wrong correspondences alone would propose.
double chance_of(const Eigen::Isometry3d& T_target_source, const Correspondences& correspondences,
                 const ConsensusOptions& options, const RandomStream& random);

/// Largest chord between an inlier's two normals; 0 without normals.
double chord_bound(const Correspondences& correspondences, double normal_noise_deg);

}  // namespace palpate::registration
