// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "palpate/registration/correspondences.hpp"

namespace palpate::registration {

/// Work that branch and bound may still do.
struct Budget {
  int nodes = 0;
  double deadline = 0;  ///< as now()
  int used = 0;
  bool is_spent = false;

  /// @return false once all is spent
  bool spend();
  /// Whether the deadline is past, so that all is spent.
  bool is_late();
};

/// Whether one pair can be an inlier of a pose with more than so many inliers, by branch and bound
/// over rotations.
///
/// With pair i an inlier, and another pair j, R (s_j - s_i) is within twice the noise bound c of
/// t_j - t_i. The most pairs that one rotation meets so bound the inliers of every pose that i is
/// an inlier of (guaranteed outlier removal: Parra Bustos & Chin, PAMI 2018). Rotations are vectors
/// in the ball of radius pi: within a cube of half side h about r none turns a vector by more than
/// sqrt(3) h from where r does (Hartley & Kahl, IJCV 2009).
class RotationBound {
 public:
  /// @param noise_bound  c, m
  RotationBound(const Correspondences& correspondences, double noise_bound)
      : correspondences_(correspondences), reach_(2 * noise_bound) {}

  /// @param others  pairs that keep their distance to the pivot
  /// @param witness  a rotation vector that met enough of them before, if any; what is found stays
  /// @return false if proven: no rotation meets `inliers` of the others
  bool can_have(int pivot, const std::vector<int>& others, int inliers,
                std::optional<Eigen::Vector3d>& witness, Budget& budget) const;

 private:
  const Correspondences& correspondences_;
  double reach_;
};

}  // namespace palpate::registration
