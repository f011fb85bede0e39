// SPDX-License-Identifier: Apache-2.0
#include "registration/certificate.hpp"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>

#include "palpate/core/error.hpp"

namespace palpate::registration {
namespace {

/// T' Q T / scale with T = blkdiag(I_3 kron R, 1): the problem in which R is the identity.
Matrix10d turned(const Matrix10d& Q, const Eigen::Matrix3d& R, double scale) {
  Matrix10d half;
  for (int c = 0; c < 3; ++c) {
    half.block<10, 3>(0, 3 * c).noalias() = Q.block<10, 3>(0, 3 * c) * (R / scale);
  }
  half.col(9) = Q.col(9) / scale;
  Matrix10d result;
  for (int c = 0; c < 3; ++c) {
    result.block<3, 10>(3 * c, 0).noalias() = R.transpose() * half.block<3, 10>(3 * c, 0);
  }
  result.row(9) = half.row(9);
  return 0.5 * (result + result.transpose());
}

/// f(R) - f* in units of the scaled problem, for any Z = Q' + sum lambda_k A_k.
double gap_bound(const Matrix10d& Z) {
  const Vector10d& r = constraint_basis().identity;
  const double least =
      Eigen::SelfAdjointEigenSolver<Matrix10d>(Z, Eigen::EigenvaluesOnly).eigenvalues()[0];
  return std::max(0.0, r.dot(Z * r)) - 4 * std::min(0.0, least);
}

}  // namespace

void check_rotation(const Eigen::Matrix3d& R) {
  if (!R.allFinite()) throw BadInput("the rotation holds a value that is not finite");
  const double off = (R.transpose() * R - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff();
  const double determinant = R.determinant();
  if (off > 1e-6 || determinant < 0) {
    throw BadInput(
        fmt::format("a rotation is off by {:.3g}, its determinant {:.3g}", off, determinant));
  }
}

DetailedCertificate certify_in_detail(const Matrix10d& objective, const Eigen::Matrix3d& R,
                                      const RotationOptions& options) {
  const auto& basis = constraint_basis();
  const Vector10d r = homogeneous(R);
  DetailedCertificate result;
  auto& [certified, cost, bound, steps] = result.certificate;
  cost = r.dot(objective * r);
  const double scale = objective.trace() / 10;
  if (!(scale > 0)) {  // no residual depends on the rotation
    certified = true;
    return result;
  }
  const Matrix10d Q = turned(objective, R, scale);
  const double allowed = options.relative_gap * std::max(cost / scale, 1.0);
  const double tolerance = allowed / 10;  // 4 go to lambda_min, the rest to what Z r_I leaves

  Matrix10d Z = Q - smat<10>(basis.stationary * (Q * basis.identity));
  Z -= smat<10>(basis.free * (basis.free.transpose() * svec<10>(Z)));
  Matrix9d Z9 = basis.complement.transpose() * Z * basis.complement;
  Matrix9d shifted = Z9;
  shifted.diagonal().array() += tolerance;
  if (Eigen::LLT<Matrix9d>(shifted).info() != Eigen::Success) {
    const BarrierResult barrier = find_multipliers(Z9, tolerance, options.max_certificate_steps);
    steps = barrier.steps;
    Z += smat<10>(basis.free * barrier.multipliers);
    if (!barrier.feasible) result.escape = basis.complement * barrier.weakest;
  }
  const double gap = gap_bound(Z);
  bound = scale * gap;
  certified = gap <= allowed;
  return result;
}

RotationCertificate certify_rotation(const Matrix10d& objective, const Eigen::Matrix3d& R,
                                     const RotationOptions& options) {
  if (!objective.allFinite()) throw BadInput("the objective holds a value that is not finite");
  check_rotation(R);
  return certify_in_detail(objective, R, options).certificate;
}

}  // namespace palpate::registration
