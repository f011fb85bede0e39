// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "palpate/core/se3.hpp"
#include "palpate/registration/correspondences.hpp"

namespace palpate::registration {

using Vector10d = Eigen::Matrix<double, 10, 1>;
using Vector13d = Eigen::Matrix<double, 13, 1>;
using Matrix10d = Eigen::Matrix<double, 10, 10>;
using Matrix13d = Eigen::Matrix<double, 13, 13>;

/// Points that coordinates are taken relative to, so that far coordinates lose no digits.
struct Origins {
  Eigen::Vector3d source = Eigen::Vector3d::Zero(), target = Eigen::Vector3d::Zero();
};

/// Means of the points of positive weight; zero where there is none.
/// @param weights  one a pair, or empty for all 1
Origins weighted_means(const Correspondences& correspondences, const std::vector<double>& weights);

/// [vec(R); 1], columns of R stacked.
Vector10d homogeneous(const Eigen::Matrix3d& R);
/// [vec(R); t; 1], thesis eq. 6.21 homogenised.
Vector13d homogeneous(const Eigen::Isometry3d& T);

/// The form M with tau' M tau = sum of weighted squared residuals, tau = [vec(R); t; 1], m^2.
///
/// Thesis eqs 6.18-6.23, with N_i = [x_i~' kron I_3 | -y_i] of size 3x13.
/// @param origins  source and target coordinates are taken relative to these
Matrix13d quadratic_form(const Correspondences& correspondences, const std::vector<double>& weights,
                         Primitive primitive, const Origins& origins = {});

/// The form with the translation at its best for every rotation.
struct MarginalForm {
  Matrix10d objective;                       ///< Q~ of thesis eq. 6.25, of [vec(R); 1]
  Eigen::Matrix<double, 3, 10> translation;  ///< t*(R) = translation [vec(R); 1]
};

/// Schur complement over the translation (thesis eqs 6.24 and 6.25); of the translations that are
/// equally good (all normals in one plane), the shortest.
MarginalForm marginalize(const Matrix13d& form);

/// J' W J of the residuals for a twist [w; v] (rad, m) of the target frame about `center`: the
/// inverse covariance of the pose for residuals of unit variance.
Matrix6d information_matrix(const Correspondences& correspondences,
                            const std::vector<double>& weights, Primitive primitive,
                            const Eigen::Isometry3d& T_target_source,
                            const Eigen::Vector3d& center = Eigen::Vector3d::Zero());

}  // namespace palpate::registration
