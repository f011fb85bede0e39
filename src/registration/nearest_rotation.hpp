// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/SVD>

namespace palpate::registration {

/// Rotation nearest to M in the Frobenius norm; never a reflection (Kabsch 1978, Umeyama 1991).
inline Eigen::Matrix3d nearest_rotation(const Eigen::Matrix3d& M) {
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(M, Eigen::ComputeFullU | Eigen::ComputeFullV);
  const Eigen::Matrix3d U = svd.matrixU(), V = svd.matrixV();
  const double sign = (U * V.transpose()).determinant() < 0 ? -1 : 1;
  return U * Eigen::Vector3d(1, 1, sign).asDiagonal() * V.transpose();
}

}  // namespace palpate::registration
