// SPDX-License-Identifier: Apache-2.0
#include "numerics/bounded_least_squares.hpp"

#include <Eigen/Cholesky>
#include <algorithm>

namespace palpate::numerics {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double kFirstDamping = 1e-3, kMinDamping = 1e-9, kLargestDamping = 1e9;
constexpr double kRidge = 1e-12;  // so that a parameter without any effect stays put

MatrixXd jacobian(const Residuals& residuals, const VectorXd& x, const VectorXd& r,
                  const VectorXd& upper, double step) {
  MatrixXd J(r.size(), x.size());
  for (Index k = 0; k < x.size(); ++k) {
    VectorXd moved = x;
    const double change = x[k] + step > upper[k] ? -step : step;
    moved[k] += change;
    J.col(k) = (residuals(moved) - r) / change;
  }
  return J;
}

/// Leaves out parameters that are at a bound and would only go beyond it.
void hold_at_bounds(const VectorXd& x, const VectorXd& lower, const VectorXd& upper, MatrixXd& J,
                    const VectorXd& r) {
  const VectorXd gradient = J.transpose() * r;
  for (Index k = 0; k < x.size(); ++k) {
    if ((x[k] <= lower[k] && gradient[k] > 0) || (x[k] >= upper[k] && gradient[k] < 0)) {
      J.col(k).setZero();
    }
  }
}

}  // namespace

LeastSquaresResult bounded_least_squares(const Residuals& residuals, const VectorXd& start,
                                         const VectorXd& lower, const VectorXd& upper,
                                         const LeastSquaresOptions& options) {
  LeastSquaresResult result{start.cwiseMax(lower).cwiseMin(upper), 0, 0};
  VectorXd r = residuals(result.x);
  result.cost = r.squaredNorm();
  double damping = kFirstDamping;
  while (result.iterations < options.iterations && damping < kLargestDamping) {
    ++result.iterations;
    MatrixXd J = jacobian(residuals, result.x, r, upper, options.difference);
    hold_at_bounds(result.x, lower, upper, J, r);
    const MatrixXd H = J.transpose() * J;
    const VectorXd g = J.transpose() * r;
    const double before = result.cost;
    for (; damping < kLargestDamping; damping *= 10) {
      MatrixXd damped = H;
      damped.diagonal() += damping * H.diagonal() + VectorXd::Constant(g.size(), kRidge);
      const VectorXd x = (result.x - damped.ldlt().solve(g)).cwiseMax(lower).cwiseMin(upper);
      const VectorXd there = residuals(x);
      if (!(there.squaredNorm() < result.cost)) continue;
      result.x = x;
      r = there;
      result.cost = there.squaredNorm();
      damping = std::max(damping / 10, kMinDamping);
      break;
    }
    if (before - result.cost <= options.tolerance * before) break;
  }
  return result;
}

}  // namespace palpate::numerics
