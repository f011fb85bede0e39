// SPDX-License-Identifier: Apache-2.0
#include "registration/dual_sdp.hpp"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/SVD>
#include <array>
#include <limits>

#include "palpate/core/error.hpp"
#include "registration/nearest_rotation.hpp"
#include "registration/rotation_constraints.hpp"

namespace palpate::registration {
namespace {

constexpr int kHomogeneous = 20;                  // independent constraints r~' A r~ = 0
constexpr int kDualVariables = kHomogeneous + 1;  // the last is gamma
using DualVariables = Eigen::Matrix<double, kDualVariables, 1>;

/// What each variable multiplies in Z, as svec columns: an orthonormal basis, then -e e'.
const Eigen::Matrix<double, 55, kDualVariables>& directions() {
  static const Eigen::Matrix<double, 55, kDualVariables> result = [] {
    const auto constraints = rotation_constraints();
    Eigen::MatrixXd homogeneous(55, static_cast<Eigen::Index>(constraints.size()) - 1);
    for (Eigen::Index k = 0; k < homogeneous.cols(); ++k) {
      homogeneous.col(k) = svec<10>(constraints[static_cast<std::size_t>(k)]);
    }
    Eigen::Matrix<double, 55, kDualVariables> columns;
    columns.leftCols<kHomogeneous>() =
        Eigen::JacobiSVD<Eigen::MatrixXd>(homogeneous, Eigen::ComputeThinU)
            .matrixU()
            .leftCols<kHomogeneous>();
    columns.col(kHomogeneous) = -svec<10>(constraints.back());
    return columns;
  }();
  return result;
}

/// min -t gamma - logdet Z(x).
class Barrier {
 public:
  explicit Barrier(const Matrix10d& Q) : Q_(Q) {
    for (int k = 0; k < kDualVariables; ++k) {
      matrices_[static_cast<std::size_t>(k)] = smat<10>(directions().col(k));
    }
  }

  Matrix10d Z(const DualVariables& x) const { return Q_ + smat<10>(directions() * x); }

  /// Strictly feasible: the norms of the columns, less 3 y^2, lift the rotation's block, and a low
  /// gamma lifts what is left.
  DualVariables start() const {
    const double lift = 1 + Q_.norm();
    Matrix10d norms = Matrix10d::Zero();
    norms.diagonal() << Eigen::Matrix<double, 9, 1>::Ones(), -3;
    DualVariables x = lift * directions().transpose() * svec<10>(norms);
    x[kHomogeneous] = -3 * lift - 2 * Q_.norm() - 1;
    return x;
  }

  double value(const DualVariables& x, double t) const {
    const Eigen::LLT<Matrix10d> cholesky(Z(x));
    if (cholesky.info() != Eigen::Success) return std::numeric_limits<double>::infinity();
    const Matrix10d L = cholesky.matrixL();
    return -t * x[kHomogeneous] - 2 * L.diagonal().array().log().sum();
  }

  struct Newton {
    DualVariables direction;
    double squared_decrement;
  };

  Newton newton(const DualVariables& x, double t) const {
    const Eigen::LLT<Matrix10d> cholesky(Z(x));
    const Matrix10d inverse = cholesky.matrixL().solve(Matrix10d::Identity());
    Eigen::Matrix<double, 55, kDualVariables> W;
    DualVariables gradient;
    for (int k = 0; k < kDualVariables; ++k) {
      const Matrix10d whitened =
          inverse * matrices_[static_cast<std::size_t>(k)] * inverse.transpose();
      W.col(k) = svec<10>(whitened);
      gradient[k] = -whitened.trace();
    }
    gradient[kHomogeneous] -= t;
    const Eigen::Matrix<double, kDualVariables, kDualVariables> hessian = W.transpose() * W;
    const DualVariables direction = -hessian.ldlt().solve(gradient);
    return {direction, -gradient.dot(direction)};
  }

 private:
  const Matrix10d& Q_;
  std::array<Matrix10d, kDualVariables> matrices_;
};

/// Newton steps to the central path at t. @return whether it was reached
bool center(const Barrier& barrier, double t, DualVariables& x, int& steps) {
  constexpr int kMaxSteps = 60;
  constexpr double kCentred = 1e-5, kSlope = 0.1;
  for (int k = 0; k < kMaxSteps; ++k) {
    const auto [direction, squared_decrement] = barrier.newton(x, t);
    if (!(squared_decrement > kCentred)) return true;
    ++steps;
    const double current = barrier.value(x, t);
    double length = 1;
    while (!(barrier.value(x + length * direction, t) <=
             current - kSlope * length * squared_decrement)) {
      length *= 0.5;
      if (length < 1e-8) return false;  // rounding hides the descent
    }
    x += length * direction;
  }
  return false;
}

/// The rotation that the least eigenvector of Z stands for.
Eigen::Matrix3d rotation_of(const Matrix10d& Z) {
  const Vector10d r = Eigen::SelfAdjointEigenSolver<Matrix10d>(Z).eigenvectors().col(0);
  const double y = r[9] < 0 ? -1 : 1;
  const Eigen::Matrix3d M = y * Eigen::Map<const Eigen::Matrix3d>(r.data());
  return nearest_rotation(M);
}

}  // namespace

DualSolution solve_dual(const Matrix10d& objective, double relative_gap) {
  if (!objective.allFinite()) throw BadInput("the objective holds a value that is not finite");
  if (!(relative_gap > 0)) {
    throw BadInput(fmt::format("relative gap {} is not positive", relative_gap));
  }
  constexpr double kGrowth = 8, kDimension = 10;
  DualSolution solution;
  const double scale = objective.trace() / 10;
  if (!(scale > 0)) {
    solution.converged = true;
    return solution;
  }
  const Matrix10d Q = objective / scale;
  const Barrier barrier(Q);
  DualVariables x = barrier.start();
  double t = 0.1;
  bool centred = center(barrier, t, x, solution.steps);
  while (centred && kDimension / t > relative_gap) {
    DualVariables next = x;
    const double larger = kGrowth * t;
    centred = center(barrier, larger, next, solution.steps);
    if (!centred) break;
    x = next;
    t = larger;
  }
  solution.converged = kDimension / t <= relative_gap;
  solution.gap = 1.01 * scale * kDimension / t;  // the path is met to a decrement of 3e-3
  solution.value = scale * x[kHomogeneous];
  solution.Z = scale * barrier.Z(x);
  solution.R = rotation_of(solution.Z);
  return solution;
}

}  // namespace palpate::registration
