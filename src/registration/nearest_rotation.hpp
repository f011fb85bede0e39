// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <Eigen/SVD>
#include <cmath>

namespace palpate::registration {

/// Rotation nearest to M in the Frobenius norm; never a reflection (Kabsch 1978, Umeyama 1991).
inline Eigen::Matrix3d nearest_rotation(const Eigen::Matrix3d& M) {
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(M, Eigen::ComputeFullU | Eigen::ComputeFullV);
  const Eigen::Matrix3d U = svd.matrixU(), V = svd.matrixV();
  const double sign = (U * V.transpose()).determinant() < 0 ? -1 : 1;
  return U * Eigen::Vector3d(1, 1, sign).asDiagonal() * V.transpose();
}

/// Rotation about a unit axis that is nearest to M: maximises tr(R' M).
inline Eigen::Matrix3d rotation_about(const Eigen::Vector3d& axis, const Eigen::Matrix3d& M) {
  // R = I cos + [a] sin + a a' (1 - cos).
  const double cosine = M.trace() - axis.dot(M * axis);
  const double sine =
      axis[0] * (M(2, 1) - M(1, 2)) + axis[1] * (M(0, 2) - M(2, 0)) + axis[2] * (M(1, 0) - M(0, 1));
  return Eigen::AngleAxisd(std::atan2(sine, cosine), axis).toRotationMatrix();
}

/// Signed determinant of A without that row and column.
inline double cofactor(const Eigen::Matrix4d& A, int row, int column) {
  Eigen::Matrix3d minor;
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) minor(i, j) = A(i + (i >= row), j + (j >= column));
  }
  return ((row + column) % 2 == 0 ? 1 : -1) * minor.determinant();
}

/// The same for the covariance sum (q - q0) (p - p0)' of two sets of points, several times faster:
/// the quaternion is the eigenvector of Horn's (1987) matrix for its largest eigenvalue, which
/// Newton's method finds from above (Theobald 2005).
/// @param bound  at least that eigenvalue: half the sum of both sets' squared norms
inline Eigen::Matrix3d rotation_between(const Eigen::Matrix3d& M, double bound) {
  const double xx = M(0, 0), xy = M(1, 0), xz = M(2, 0), yx = M(0, 1), yy = M(1, 1), yz = M(2, 1),
               zx = M(0, 2), zy = M(1, 2), zz = M(2, 2);  // source axis first
  Eigen::Matrix4d K;
  K << xx + yy + zz, yz - zy, zx - xz, xy - yx,  //
      yz - zy, xx - yy - zz, xy + yx, zx + xz,   //
      zx - xz, xy + yx, yy - xx - zz, yz + zy,   //
      xy - yx, zx + xz, yz + zy, zz - xx - yy;
  const double c2 = -2 * M.squaredNorm(), c1 = -8 * M.determinant(), c0 = K.determinant();
  constexpr int kMaxSteps = 50;
  double eigenvalue = bound;
  for (int step = 0; step < kMaxSteps; ++step) {
    const double square = eigenvalue * eigenvalue, b = (square + c2) * eigenvalue, a = b + c1;
    const double slope = 2 * square * eigenvalue + b + a;
    if (slope <= 0) break;
    const double change = (a * eigenvalue + c0) / slope;
    eigenvalue -= change;
    if (std::abs(change) < 1e-11 * eigenvalue) break;
  }
  // Any column of the adjugate is the eigenvector; the longest is the most exact.
  const Eigen::Matrix4d A = K - eigenvalue * Eigen::Matrix4d::Identity();
  Eigen::Vector4d q = Eigen::Vector4d::Zero();
  for (int column = 0; column < 4; ++column) {
    Eigen::Vector4d cofactors;
    for (int row = 0; row < 4; ++row) cofactors[row] = cofactor(A, row, column);
    if (cofactors.squaredNorm() > q.squaredNorm()) q = cofactors;
  }
  if (!(q.norm() > 1e-6 * bound * bound * bound)) return nearest_rotation(M);
  q.normalize();
  return Eigen::Quaterniond(q[0], q[1], q[2], q[3]).toRotationMatrix();
}

}  // namespace palpate::registration
