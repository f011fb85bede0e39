// SPDX-License-Identifier: Apache-2.0
#include "registration/rotation_constraints.hpp"

#include <Eigen/QR>
#include <Eigen/SVD>

namespace palpate::registration {
namespace {

constexpr int kIndependent = 21, kGradientRank = 7;
static_assert(kIndependent - kGradientRank == kFreeMultipliers);

int entry(int row, int column) { return 3 * column + row; }

/// Adds the monomial value * r_i r_j to a symmetric form.
void add_product(Matrix10d& form, int i, int j, double value) {
  form(i, j) += value / 2;
  form(j, i) += value / 2;
}

/// Inner product of two columns (or two rows) of R, less y^2 on the diagonal.
Matrix10d orthonormality(int a, int b, bool columns) {
  Matrix10d form = Matrix10d::Zero();
  for (int k = 0; k < 3; ++k) {
    add_product(form, columns ? entry(k, a) : entry(a, k), columns ? entry(k, b) : entry(b, k), 1);
  }
  if (a == b) form(9, 9) -= 1;
  return form;
}

/// Component k of R(c) x R(c+1) - y R(c+2), cyclic.
Matrix10d handedness(int c, int k) {
  const int next = (c + 1) % 3, last = (c + 2) % 3, p = (k + 1) % 3, q = (k + 2) % 3;
  Matrix10d form = Matrix10d::Zero();
  add_product(form, entry(p, c), entry(q, next), 1);
  add_product(form, entry(q, c), entry(p, next), -1);
  add_product(form, entry(k, last), 9, -1);
  return form;
}

ConstraintBasis make_basis() {
  const auto constraints = rotation_constraints();
  Eigen::MatrixXd all(55, static_cast<Eigen::Index>(constraints.size()));
  for (Eigen::Index k = 0; k < all.cols(); ++k) {
    all.col(k) = svec<10>(constraints[static_cast<std::size_t>(k)]);
  }
  const Eigen::MatrixXd span =
      Eigen::JacobiSVD<Eigen::MatrixXd>(all, Eigen::ComputeThinU).matrixU().leftCols(kIndependent);

  ConstraintBasis basis;
  basis.identity = homogeneous(Eigen::Matrix3d(Eigen::Matrix3d::Identity()));
  const Eigen::HouseholderQR<Eigen::MatrixXd> qr(basis.identity);
  basis.complement = Eigen::MatrixXd(qr.householderQ()).rightCols<9>();

  Eigen::MatrixXd gradients(10, kIndependent);
  for (int k = 0; k < kIndependent; ++k) {
    gradients.col(k) = smat<10>(span.col(k)) * basis.identity;
  }
  const Eigen::JacobiSVD<Eigen::MatrixXd> svd(gradients, Eigen::ComputeFullU | Eigen::ComputeFullV);
  const Eigen::VectorXd inverse = svd.singularValues().head(kGradientRank).cwiseInverse();
  basis.stationary = span * svd.matrixV().leftCols(kGradientRank) * inverse.asDiagonal() *
                     svd.matrixU().leftCols(kGradientRank).transpose();
  basis.free = span * svd.matrixV().rightCols(kFreeMultipliers);
  for (int j = 0; j < kFreeMultipliers; ++j) {
    const Matrix9d B =
        basis.complement.transpose() * smat<10>(basis.free.col(j)) * basis.complement;
    basis.free_matrices[static_cast<std::size_t>(j)] = B;
    basis.free_compressed.col(j) = svec<9>(B);
  }
  return basis;
}

}  // namespace

std::vector<Matrix10d> rotation_constraints() {
  std::vector<Matrix10d> constraints;
  for (const bool columns : {true, false}) {
    for (int a = 0; a < 3; ++a) {
      for (int b = a; b < 3; ++b) constraints.push_back(orthonormality(a, b, columns));
    }
  }
  for (int c = 0; c < 3; ++c) {
    for (int k = 0; k < 3; ++k) constraints.push_back(handedness(c, k));
  }
  constraints.push_back(Matrix10d::Zero());
  constraints.back()(9, 9) = 1;
  return constraints;
}

const ConstraintBasis& constraint_basis() {
  static const ConstraintBasis basis = make_basis();
  return basis;
}

}  // namespace palpate::registration
