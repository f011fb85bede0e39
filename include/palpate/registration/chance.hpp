// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace palpate::registration {

/// What wrong correspondences alone would bring about.
struct ChanceModel {
  /// Triples of correspondences that are consistent by chance; each proposes a pose.
  double triples = 0;
  /// Correspondences that a pose has within the bound by chance, on average.
  double rate = 0;
  /// Dimension of one residual: 3 for positions, 5 with normals.
  int dimensions = 3;
};

/// Expected number of poses about which chance gathers such a consensus (an a-contrario test in the
/// sense of Desolneux, Moisan & Morel 2000; Moisan & Stival 2004, with the residuals instead of
/// their largest).
///
/// Residuals are in units of the bound. Those of wrong correspondences have uniform density, so
/// that sets of k that fit a pose with a sum of squared residuals up to S are counted by a volume:
/// the ball of radius sqrt(S) in d k - 6 dimensions, the pose taking up 6. The count starts from
/// that of the triples that pass the consistency graph's gates, each of a known volume in 3 d - 6
/// dimensions; every further correspondence brings the density rate / volume of the unit ball. The
/// k choose 3 triples of a set are one pose, and a pose held by k instead of 3 correspondences
/// yields less to each of them, by (k / 3)^3 in all: the root of the ratio of the determinants of
/// the information.
/// @param squares  S, sum of the squared residuals of the inliers, d-dimensional
/// @param count  k, inliers; fewer than three are always expected
double expected_by_chance(const ChanceModel& model, double squares, int count);

}  // namespace palpate::registration
