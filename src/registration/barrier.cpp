// SPDX-License-Identifier: Apache-2.0
#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>

#include "registration/certificate.hpp"

namespace palpate::registration {
namespace {

constexpr int kBarrierVariables = kFreeMultipliers + 1;  // the last is sigma
using BarrierVariables = Eigen::Matrix<double, kBarrierVariables, 1>;

bool positive_definite(const Matrix9d& S) {
  return Eigen::LLT<Matrix9d>(S).info() == Eigen::Success;
}

/// Z9 + sum x_j B_j + x_sigma I
Matrix9d combined(const Matrix9d& Z9, const BarrierVariables& x) {
  const auto& basis = constraint_basis();
  Matrix9d S = Z9 + smat<9>(basis.free_compressed * x.head<kFreeMultipliers>());
  S.diagonal().array() += x[kFreeMultipliers];
  return S;
}

struct NewtonStep {
  BarrierVariables direction;
  double decrement = 0;
};

/// Newton step of t sigma - logdet F; H_ij = tr(W_i W_j), W_j = L^-1 B_j L^-T.
NewtonStep newton_step(const Matrix9d& F, double t) {
  const auto& basis = constraint_basis();
  const Eigen::LLT<Matrix9d> cholesky(F);
  const Matrix9d inverse = cholesky.matrixL().solve(Matrix9d::Identity());
  Eigen::Matrix<double, 45, kBarrierVariables> W;
  BarrierVariables gradient;
  for (int j = 0; j < kBarrierVariables; ++j) {
    Matrix9d w = inverse;
    if (j < kFreeMultipliers) {
      w.noalias() =
          inverse.triangularView<Eigen::Lower>() * basis.free_matrices[static_cast<std::size_t>(j)];
    }
    const Matrix9d whitened = w * inverse.transpose();
    W.col(j) = svec<9>(whitened);
    gradient[j] = -whitened.trace();
  }
  gradient[kFreeMultipliers] += t;
  const Eigen::Matrix<double, kBarrierVariables, kBarrierVariables> hessian = W.transpose() * W;
  NewtonStep step;
  step.direction = -hessian.ldlt().solve(gradient);
  step.decrement = std::sqrt(std::max(0.0, -gradient.dot(step.direction)));
  return step;
}

}  // namespace

BarrierResult find_multipliers(const Matrix9d& Z9, double tolerance, int max_steps) {
  constexpr double kGrowth = 6, kCentred = 0.5;
  const double least =
      Eigen::SelfAdjointEigenSolver<Matrix9d>(Z9, Eigen::EigenvaluesOnly).eigenvalues()[0];
  BarrierVariables x = BarrierVariables::Zero();
  double& sigma = x[kFreeMultipliers];
  sigma = 1.5 * std::abs(least) + 1e-3 * Z9.norm() + tolerance;
  double t = 1 / sigma;
  BarrierResult result;
  while (result.steps < max_steps) {
    const NewtonStep step = newton_step(combined(Z9, x), t);
    ++result.steps;
    // On the central path sigma exceeds the least possible one by less than this gap.
    const double gap = (9 + 3 * step.decrement) / t;
    const bool centred = step.decrement < kCentred;
    if (centred && sigma - gap > tolerance) break;
    double length = step.decrement > 0.6 ? 1 / (1 + step.decrement) : 1;
    while (!positive_definite(combined(Z9, x + length * step.direction)) && length > 1e-9) {
      length *= 0.5;
    }
    x += length * step.direction;
    BarrierVariables shifted = x;
    shifted[kFreeMultipliers] = tolerance;
    result.feasible = positive_definite(combined(Z9, shifted));
    if (result.feasible) break;
    if (centred) t *= kGrowth;
  }
  result.multipliers = x.head<kFreeMultipliers>();
  sigma = 0;
  const Eigen::SelfAdjointEigenSolver<Matrix9d> eigen(combined(Z9, x));
  result.weakest = eigen.eigenvectors().col(0);
  return result;
}

}  // namespace palpate::registration
