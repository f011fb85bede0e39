// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <vector>

namespace palpate::numerics {

/// Minimise x'P x / 2 + q'x such that F x + g lies in a product of Lorentz cones
/// u_0 >= |u_1..u_k|, of the given sizes (a size of 1: u_0 >= 0).
struct ConeProgram {
  Eigen::MatrixXd P;
  Eigen::VectorXd q;
  Eigen::MatrixXd F;
  Eigen::VectorXd g;
  std::vector<int> sizes;
};

struct ConeSolution {
  Eigen::VectorXd x;
  double gap = 0;  ///< the objective is at most this far above the least, if all steps converged
  int steps = 0;   ///< of Newton's method
};

/// Least u_0 - |u_1..| over the cones: positive strictly inside.
double min_slack(const Eigen::VectorXd& u, const std::vector<int>& sizes);

/// Interior-point method with the logarithmic barrier (Boyd & Vandenberghe, Convex Optimization,
/// 2004, 11.3 and 11.6). For small dense problems whose feasible set is bounded where the objective
/// is flat.
/// @param start  strictly feasible
/// @param accuracy  the gap at which to stop
ConeSolution solve(const ConeProgram& program, const Eigen::VectorXd& start, double accuracy);

}  // namespace palpate::numerics
