// SPDX-License-Identifier: Apache-2.0
#include "palpate/core/se3.hpp"

#include <fmt/format.h>

#include <cmath>
#include <utility>

#include "palpate/core/error.hpp"

namespace palpate {
namespace {

/// rad; below it the Taylor terms are exact to machine precision.
constexpr double kTinyAngle = 1e-4;

/// Coefficients of the left Jacobian: (1 - cos a) / a^2 and (a - sin a) / a^3.
std::pair<double, double> jacobian_coefficients(double angle) {
  const double square = angle * angle;
  if (angle < kTinyAngle) return {0.5 - square / 24, 1.0 / 6 - square / 120};
  const double half_sine = std::sin(angle / 2);
  return {2 * half_sine * half_sine / square, (angle - std::sin(angle)) / (square * angle)};
}

Eigen::Matrix3d left_jacobian(const Eigen::Vector3d& w) {
  const auto [a, b] = jacobian_coefficients(w.norm());
  const Eigen::Matrix3d W = skew(w);
  return Eigen::Matrix3d::Identity() + a * W + b * W * W;
}

}  // namespace

Eigen::Matrix3d skew(const Eigen::Vector3d& a) {
  Eigen::Matrix3d S;
  S << 0, -a.z(), a.y(), a.z(), 0, -a.x(), -a.y(), a.x(), 0;
  return S;
}

Eigen::Matrix3d exp_so3(const Eigen::Vector3d& w) {
  const double half = w.norm() / 2;
  const double sinc = half < kTinyAngle ? 1 - half * half / 6 : std::sin(half) / half;
  Eigen::Quaterniond q;
  q.w() = std::cos(half);
  q.vec() = 0.5 * sinc * w;
  return q.normalized().toRotationMatrix();
}

Eigen::Vector3d log_so3(const Eigen::Matrix3d& R) {
  // Through the quaternion, which is well conditioned at tiny angles and near pi alike.
  Eigen::Quaterniond q(R);
  if (q.w() < 0) q.coeffs() = -q.coeffs();
  const double sine = q.vec().norm();
  if (sine < kTinyAngle) return (2 / q.w()) * (1 - sine * sine / (3 * q.w() * q.w())) * q.vec();
  return 2 * std::atan2(sine, q.w()) / sine * q.vec();
}

Eigen::Isometry3d exp_se3(const Vector6d& twist) {
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.linear() = exp_so3(twist.head<3>());
  T.translation() = left_jacobian(twist.head<3>()) * twist.tail<3>();
  return T;
}

Vector6d log_se3(const Eigen::Isometry3d& T) {
  Vector6d twist;
  twist.head<3>() = log_so3(T.linear());
  twist.tail<3>() = left_jacobian(twist.head<3>()).partialPivLu().solve(T.translation());
  return twist;
}

Matrix6d adjoint(const Eigen::Isometry3d& T) {
  Matrix6d Ad = Matrix6d::Zero();
  Ad.topLeftCorner<3, 3>() = T.linear();
  Ad.bottomRightCorner<3, 3>() = T.linear();
  Ad.bottomLeftCorner<3, 3>() = skew(T.translation()) * T.linear();
  return Ad;
}

double rotation_distance(const Eigen::Matrix3d& a, const Eigen::Matrix3d& b) {
  return log_so3(a.transpose() * b).norm();
}

Eigen::Matrix3d frame_with_z(const Eigen::Vector3d& axis) {
  const Eigen::Vector3d helper =
      std::abs(axis.x()) < 0.8 ? Eigen::Vector3d::UnitX() : Eigen::Vector3d::UnitY();
  Eigen::Matrix3d frame;
  frame.col(0) = helper.cross(axis).normalized();
  frame.col(1) = axis.cross(frame.col(0));
  frame.col(2) = axis;
  return frame;
}

Eigen::Isometry3d pose_from_row_major(const std::array<double, 16>& values) {
  const Eigen::Matrix4d M =
      Eigen::Map<const Eigen::Matrix<double, 4, 4, Eigen::RowMajor>>(values.data());
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (!std::isfinite(values[i])) {
      throw BadInput(fmt::format("element {} of a pose is {}", i, values[i]));
    }
  }
  const Eigen::Matrix3d R = M.topLeftCorner<3, 3>();
  const double off = (R * R.transpose() - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff();
  if (off > 1e-6 || R.determinant() < 0) {
    throw BadInput(
        fmt::format("a pose is not a rigid motion: R R' of its rotation matrix R differs from the "
                    "identity by {:.3g}, and the determinant of R is {:.3g}",
                    off, R.determinant()));
  }
  if (M.row(3) != Eigen::RowVector4d(0, 0, 0, 1)) {
    throw BadInput(fmt::format("the last row of a pose is {} {} {} {}, not 0 0 0 1", M(3, 0),
                               M(3, 1), M(3, 2), M(3, 3)));
  }
  return Eigen::Isometry3d(M);
}

std::array<double, 16> pose_to_row_major(const Eigen::Isometry3d& T) {
  std::array<double, 16> values;
  Eigen::Map<Eigen::Matrix<double, 4, 4, Eigen::RowMajor>>(values.data()) = T.matrix();
  return values;
}

}  // namespace palpate
