// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

namespace palpate::numerics {

/// Covariances of the columns of a and b (features x n): a squared exponential, whose length is in
/// root-mean-square features, and `linear` times a linear kernel (Rasmussen & Williams 2006, eq.
/// 4.9).
inline Eigen::MatrixXd kernel(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b, double length,
                              double linear) {
  const Eigen::MatrixXd products = a.transpose() * b;
  const Eigen::VectorXd aa = a.colwise().squaredNorm(), bb = b.colwise().squaredNorm();
  const Eigen::MatrixXd squared =
      (-2 * products).colwise() + aa + bb.transpose().replicate(aa.size(), 1);
  const double scale = static_cast<double>(a.rows());
  return (-squared.array() / (2 * length * length * scale)).exp() +
         linear * (1 + products.array()) / scale;
}

}  // namespace palpate::numerics
