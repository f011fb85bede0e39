// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <functional>

namespace palpate::numerics {

/// Residuals at x; their number must not change.
using Residuals = std::function<Eigen::VectorXd(const Eigen::VectorXd& x)>;

struct LeastSquaresOptions {
  int iterations = 50;
  double difference = 1e-6;  ///< step of the numerical derivatives
  double tolerance = 1e-9;   ///< relative decrease of the cost at which to stop
};

struct LeastSquaresResult {
  Eigen::VectorXd x;
  double cost = 0;  ///< squared norm of the residuals
  int iterations = 0;
};

/// Minimises |r(x)|^2 within lower <= x <= upper by damped Gauss-Newton steps (Levenberg 1944) that
/// are projected onto the bounds; derivatives are forward differences.
LeastSquaresResult bounded_least_squares(const Residuals& residuals, const Eigen::VectorXd& start,
                                         const Eigen::VectorXd& lower, const Eigen::VectorXd& upper,
                                         const LeastSquaresOptions& options = {});

}  // namespace palpate::numerics
