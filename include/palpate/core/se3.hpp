// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Geometry>
#include <array>

namespace palpate {

using Vector6d = Eigen::Matrix<double, 6, 1>;
using Matrix6d = Eigen::Matrix<double, 6, 6>;

/// Cross-product matrix: skew(a) b = a x b.
Eigen::Matrix3d skew(const Eigen::Vector3d& a);

/// Rotation of angle |w| (rad) about w; accurate at tiny angles.
Eigen::Matrix3d exp_so3(const Eigen::Vector3d& w);

/// Rotation vector w (rad, |w| <= pi) with exp_so3(w) = R; accurate near 0 and near pi.
Eigen::Vector3d log_so3(const Eigen::Matrix3d& R);

/// Rigid motion of the twist [w; v] (rotation first; rad, m).
Eigen::Isometry3d exp_se3(const Vector6d& twist);

/// Twist [w; v] with exp_se3(twist) = T.
Vector6d log_se3(const Eigen::Isometry3d& T);

/// Adjoint of T for twists [w; v]: T exp(x) T^-1 = exp(Ad_T x).
Matrix6d adjoint(const Eigen::Isometry3d& T);

/// Angle (rad, 0..pi) of the rotation between a and b.
double rotation_distance(const Eigen::Matrix3d& a, const Eigen::Matrix3d& b);

/// An orthonormal frame whose third axis is the unit vector `axis`.
Eigen::Matrix3d frame_with_z(const Eigen::Vector3d& axis);

/// Pose of 16 numbers, row-major. @throws BadInput unless it is finite and a rigid motion to 1e-6.
Eigen::Isometry3d pose_from_row_major(const std::array<double, 16>& values);
std::array<double, 16> pose_to_row_major(const Eigen::Isometry3d& T);

}  // namespace palpate
