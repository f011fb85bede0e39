// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <algorithm>

namespace palpate::numerics {

struct LeastSquaresOptions {
  int iterations = 12;
  double damping = 1e-2;   ///< at the start
  double min_gain = 1e-3;  ///< of the sum of squares, that is worth another iteration
  double max_step = 30;    ///< of each unknown, in widths
};

template <class State>
struct LeastSquaresFit {
  State state;
  Eigen::VectorXd residuals;
  Eigen::MatrixXd information;  ///< J'J, in units of the widths
  int iterations = 0;
};

/// Least sum of squares near a start (Levenberg 1944, Marquardt 1963), by central differences.
/// @param width  by which each unknown is moved to differentiate, and its unit
/// @param residuals  of a state
/// @param moved  (state, step in the unknowns' own units) -> state; it may hold the state within
///               bounds
template <class State, class Residuals, class Moved>
LeastSquaresFit<State> levenberg_marquardt(const State& start, const Eigen::VectorXd& width,
                                           const Residuals& residuals, const Moved& moved,
                                           const LeastSquaresOptions& options = {}) {
  const Eigen::Index unknowns = width.size();
  LeastSquaresFit<State> fit{
      .state = start, .residuals = residuals(start), .information = {}, .iterations = 0};
  double damping = options.damping;
  for (int iteration = 0; iteration < options.iterations; ++iteration) {
    ++fit.iterations;
    Eigen::MatrixXd slope(fit.residuals.size(), unknowns);
    for (Eigen::Index k = 0; k < unknowns; ++k) {
      const Eigen::VectorXd step = width[k] * Eigen::VectorXd::Unit(unknowns, k);
      slope.col(k) = (residuals(moved(fit.state, step)) - residuals(moved(fit.state, -step))) / 2;
    }
    fit.information = slope.transpose() * slope;
    const Eigen::VectorXd down = slope.transpose() * fit.residuals;
    double gain = 0;
    for (int attempt = 0; attempt < 4 && gain <= 0; ++attempt) {
      Eigen::MatrixXd damped = fit.information;
      damped.diagonal() *= 1 + damping;
      damped.diagonal().array() += 1e-9;
      const Eigen::VectorXd step =
          -damped.ldlt().solve(down).cwiseMax(-options.max_step).cwiseMin(options.max_step);
      const State next = moved(fit.state, width.cwiseProduct(step));
      const Eigen::VectorXd left = residuals(next);
      gain = fit.residuals.squaredNorm() - left.squaredNorm();
      damping = gain > 0 ? std::max(1e-6, damping / 5) : damping * 8;
      if (gain <= 0) continue;
      fit.state = next;
      fit.residuals = left;
    }
    if (gain < options.min_gain) break;
  }
  return fit;
}

}  // namespace palpate::numerics
