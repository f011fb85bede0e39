// SPDX-License-Identifier: Apache-2.0
#include "palpate/learning/demonstrations/minimum_jerk.hpp"

#include <fmt/format.h>

#include <Eigen/SparseCholesky>
#include <algorithm>
#include <cmath>
#include <vector>

#include "palpate/core/error.hpp"

namespace palpate::learning {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using Sparse = Eigen::SparseMatrix<double>;

constexpr double kTight = 1e-12;  // weight, in steps^6, that goes through the points

void check(const VectorXd& times, const MatrixXd& points, double smoothing, double step) {
  if (points.cols() == 0 || points.rows() == 0) throw BadInput("a motion through no points");
  if (times.size() != points.cols()) {
    throw BadInput(fmt::format("{} times of {} points", times.size(), points.cols()));
  }
  if (!times.allFinite() || !points.allFinite()) {
    throw BadInput("a motion through points that are not finite");
  }
  if (!(step > 0) || !(smoothing >= 0)) {
    throw BadInput(fmt::format("a motion in steps of {} s, smoothed by {} s", step, smoothing));
  }
  for (Index i = 1; i < times.size(); ++i) {
    if (!(times[i] > times[i - 1])) {
      throw BadInput(fmt::format("time {} does not come after {}", times[i], times[i - 1]));
    }
  }
}

/// Third differences of n samples.
Sparse third_differences(Index n) {
  std::vector<Eigen::Triplet<double>> entries;
  for (Index i = 0; i + 3 < n; ++i) {
    entries.emplace_back(i, i, -1);
    entries.emplace_back(i, i + 1, 3);
    entries.emplace_back(i, i + 2, -3);
    entries.emplace_back(i, i + 3, 1);
  }
  Sparse result(std::max<Index>(n - 3, 0), n);
  result.setFromTriplets(entries.begin(), entries.end());
  return result;
}

/// Interpolation between samples at the given times.
Sparse readings(const VectorXd& times, Index n, double step) {
  std::vector<Eigen::Triplet<double>> entries;
  for (Index i = 0; i < times.size(); ++i) {
    const double place = (times[i] - times[0]) / step;
    const Index low = std::clamp<Index>(static_cast<Index>(place), 0, std::max<Index>(n - 2, 0));
    const double share = std::min(place - static_cast<double>(low), 1.0);
    entries.emplace_back(i, low, 1 - share);
    if (n > 1) entries.emplace_back(i, low + 1, share);
  }
  Sparse result(times.size(), n);
  result.setFromTriplets(entries.begin(), entries.end());
  return result;
}

/// Central differences; at the ends as next to them.
MatrixXd derivative(const MatrixXd& values, double step) {
  MatrixXd result = MatrixXd::Zero(values.rows(), values.cols());
  const Index n = values.cols();
  if (n < 3) return result;
  result.middleCols(1, n - 2) = (values.rightCols(n - 2) - values.leftCols(n - 2)) / (2 * step);
  result.col(0) = result.col(1);
  result.col(n - 1) = result.col(n - 2);
  return result;
}

}  // namespace

Motion minimum_jerk(const VectorXd& times, const MatrixXd& points, double smoothing, double step) {
  check(times, points, smoothing, step);
  const double duration = times[times.size() - 1] - times[0];
  const Index n = static_cast<Index>(std::lround(std::ceil(duration / step - 1e-9))) + 1;
  const Sparse read = readings(times, n, step), jerk = third_differences(n);
  // A bump of width w costs w^-6 of jerk for each sample that it spans.
  const double spacing = times.size() > 1 ? duration / static_cast<double>(times.size() - 1) : step;
  const double weight = std::max(std::pow(smoothing / step, 6) * step / spacing, kTight);
  Sparse ridge(n, n);
  ridge.setIdentity();
  const Sparse normal = Sparse(read.transpose() * read) + weight * Sparse(jerk.transpose() * jerk) +
                        kTight * kTight * ridge;
  const Eigen::SimplicialLDLT<Sparse> solver(normal);
  Motion motion;
  motion.step = step;
  motion.position = solver.solve(MatrixXd(read.transpose() * points.transpose())).transpose();
  motion.velocity = derivative(motion.position, step);
  motion.acceleration = derivative(motion.velocity, step);
  return motion;
}

double minimum_jerk_share(double time) {
  const double t = std::clamp(time, 0.0, 1.0);
  return t * t * t * (10 + t * (6 * t - 15));
}

}  // namespace palpate::learning
