// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "palpate/registration/quadratic_form.hpp"

namespace palpate::registration {

/// Solution of the dual problem.
struct DualSolution {
  double value = 0;                 ///< gamma, m^2: no rotation costs less
  double gap = 0;                   ///< the dual's optimum exceeds the value by at most this, m^2
  Matrix10d Z = Matrix10d::Zero();  ///< penalised matrix, positive definite, m^2
  Eigen::Matrix3d R = Eigen::Matrix3d::Identity();  ///< rotation nearest to the null space of Z
  int steps = 0;                                    ///< Newton steps
  bool converged = false;
};

/// The semidefinite program that the fast solve is measured against: max gamma subject to
/// Z = Q~ + sum lambda_k A_k - gamma e e' >= 0 (thesis problem D; Briales & Gonzalez-Jimenez 2017),
/// 20 independent homogeneous constraints and y^2 = 1, by a barrier interior-point method
/// (Boyd & Vandenberghe 2004, 11.3). Some hundred times slower than solve_rotation().
/// @param objective  Q~, symmetric 10x10, m^2
/// @param relative_gap  aimed at, of tr(Q~)/10
/// @throws BadInput if the objective holds a value that is not finite or the gap is not positive
DualSolution solve_dual(const Matrix10d& objective, double relative_gap = 1e-8);

}  // namespace palpate::registration
