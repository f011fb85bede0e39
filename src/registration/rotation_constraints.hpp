// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <vector>

#include "palpate/registration/quadratic_form.hpp"

namespace palpate::registration {

using Matrix9d = Eigen::Matrix<double, 9, 9>;
inline constexpr int kFreeMultipliers = 14;

/// Lower triangle by columns, off-diagonal entries times sqrt 2: keeps the inner product.
template <int n>
Eigen::Matrix<double, n*(n + 1) / 2, 1> svec(const Eigen::Matrix<double, n, n>& S) {
  constexpr double kRoot2 = 1.4142135623730951;
  Eigen::Matrix<double, n*(n + 1) / 2, 1> v;
  for (int j = 0, k = 0; j < n; ++j) {
    v[k++] = S(j, j);
    for (int i = j + 1; i < n; ++i) v[k++] = kRoot2 * S(i, j);
  }
  return v;
}

/// Inverse of svec.
template <int n>
Eigen::Matrix<double, n, n> smat(const Eigen::Matrix<double, n*(n + 1) / 2, 1>& v) {
  constexpr double kRootHalf = 0.7071067811865476;
  Eigen::Matrix<double, n, n> S;
  for (int j = 0, k = 0; j < n; ++j) {
    S(j, j) = v[k++];
    for (int i = j + 1; i < n; ++i) S(i, j) = S(j, i) = kRootHalf * v[k++];
  }
  return S;
}

/// The 22 matrices A_k of thesis problem P: r~' A_k r~ = 0 for [vec(R); y] with R in y SO(3),
/// except the last, for which it is y^2.
std::vector<Matrix10d> rotation_constraints();

/// What the certificate needs of the constraints, all at the identity r_I = [vec(I); 1], to which
/// every candidate is turned.
struct ConstraintBasis {
  Vector10d identity;                                           ///< r_I
  Eigen::Matrix<double, 10, 9> complement;                      ///< U, orthonormal, U' r_I = 0
  Eigen::Matrix<double, 55, 10> stationary;                     ///< least multipliers: svec of the
                                                                ///< matrix S with S r_I = g nearest
  Eigen::Matrix<double, 55, kFreeMultipliers> free;             ///< svec of B_j, B_j r_I = 0
  Eigen::Matrix<double, 45, kFreeMultipliers> free_compressed;  ///< svec of U' B_j U
  std::array<Matrix9d, kFreeMultipliers> free_matrices;         ///< U' B_j U
};

const ConstraintBasis& constraint_basis();

}  // namespace palpate::registration
