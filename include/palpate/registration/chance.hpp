// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace palpate::registration {

/// What wrong correspondences alone would bring about.
struct ChanceModel {
  /// Triples of correspondences that are consistent by chance; each proposes a pose.
  double triples = 0;
  /// Correspondences that a pose has within the noise bound by chance, on average.
  double rate = 0;
  /// Dimension of the ball that they fall into uniformly: 3 for positions, 5 with normals.
  int dimensions = 3;
};

/// Expected number of poses that gather such a consensus by chance (an a-contrario test: Desolneux,
/// Moisan & Morel 2000; Moisan & Stival 2004, with the gain instead of the count).
///
/// A correspondence gains g = max(0, 1 - (residual / bound)^2). By chance its residual is uniform
/// in the ball, P(g > x) = (1 - x)^(dimensions / 2), and the number in the ball is Poisson. The sum
/// of gains is then a compound Poisson variable, whose tail is summed exactly on a grid (Panjer
/// 1981), rounded up.
/// @param gain  sum of gains beyond those of the three largest, which the pose was fitted to
double expected_by_chance(const ChanceModel& model, double gain);

}  // namespace palpate::registration
