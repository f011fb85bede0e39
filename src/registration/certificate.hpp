// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "palpate/registration/rotation.hpp"
#include "registration/rotation_constraints.hpp"

namespace palpate::registration {

/// A certificate, and where it fails the way out of the minimum.
struct DetailedCertificate {
  RotationCertificate certificate;
  /// Direction in [vec(R); 1], in the candidate's frame (R = I), along which the relaxed problem
  /// descends; zero if certified.
  Vector10d escape = Vector10d::Zero();
};

/// A reflection may cost less than every rotation and would be proven of the reflections: no other
/// matrix may pass for a rotation.
/// @throws BadInput unless R is a rotation to 1e-6
void check_rotation(const Eigen::Matrix3d& R);

/// @param R  a rotation
DetailedCertificate certify_in_detail(const Matrix10d& objective, const Eigen::Matrix3d& R,
                                      const RotationOptions& options);

/// Multipliers found by the barrier method.
struct BarrierResult {
  Eigen::Matrix<double, kFreeMultipliers, 1> multipliers;
  bool feasible = false;  ///< Z9 + sum multipliers_j B_j + tolerance I is positive definite
  int steps = 0;
  Eigen::Matrix<double, 9, 1> weakest;  ///< eigenvector of the least eigenvalue reached
};

/// Searches multipliers z that make Z9 + sum z_j B_j positive semidefinite: Newton steps on
/// min t sigma - logdet(Z9 + sum z_j B_j + sigma I), t growing (Boyd & Vandenberghe 2004, 11.4);
/// stops at the first success, or when the duality gap proves that there are none.
BarrierResult find_multipliers(const Matrix9d& Z9, double tolerance, int max_steps);

}  // namespace palpate::registration
