// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "palpate/core/random.hpp"
#include "palpate/registration/registration.hpp"

namespace palpate::registration {

struct ConsensusOptions {
  double noise_bound = 0.004;      ///< m
  double normal_noise_deg = 0;     ///< per tangent axis; 0: without normals
  double max_false_alarms = 0.01;  ///< poses that wrong pairs may propose per problem
  bool best_effort = false;        ///< find the best pose even where wrong pairs propose it
  double support_radius = 0;       ///< m; 0: four noise bounds
  AllowedTurns turns = {};
};

struct Consensus {
  Eigen::Isometry3d T_target_source = Eigen::Isometry3d::Identity();
  bool found = false;        ///< wrong pairs do not explain it
  double false_alarms = 1;   ///< poses as good as this one among wrong correspondences alone
  int hypotheses = 0;        ///< cliques tried
  bool mirrored = false;     ///< more pairs agree with a reflection
  double false_inliers = 0;  ///< of the pose's inliers, wrong ones to be expected
  std::optional<RunnerUp> runner_up;
};

/// Pose of the largest truncated gain over all correspondences: cliques of the consistency graph,
/// each grown in the neighbourhood of one correspondence of a growing sample, propose poses, which
/// are refined on all correspondences, until a larger consensus would have come up.
Consensus find_consensus(const Correspondences& correspondences, const ConsensusOptions& options,
                         const RandomStream& random);

/// The pose that inliers and least squares lead to from a given one, the bound narrowing from
/// `reach` times itself.
Consensus refine_consensus(const Correspondences& correspondences, const Eigen::Isometry3d& initial,
                           double reach, const ConsensusOptions& options,
                           const RandomStream& random);

/// How many poses as good as T wrong correspondences alone would propose.
double false_alarms_of(const Eigen::Isometry3d& T_target_source,
                       const Correspondences& correspondences, const ConsensusOptions& options,
                       const RandomStream& random);

/// Largest chord between an inlier's two normals; 0 without normals.
double chord_bound(const Correspondences& correspondences, double normal_noise_deg);

}  // namespace palpate::registration
