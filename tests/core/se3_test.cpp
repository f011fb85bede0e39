// SPDX-License-Identifier: Apache-2.0
#include "palpate/core/se3.hpp"

#include <gtest/gtest.h>

#include <limits>
#include <unsupported/Eigen/MatrixFunctions>
#include <vector>

#include "core/error_message.hpp"
#include "palpate/core/angle.hpp"
#include "palpate/core/random.hpp"

namespace palpate {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

/// Angles (rad) from nothing to pi, dense where formulas lose digits.
std::vector<double> angles() {
  return {0,          1e-300,     1e-16,      1e-12,      1e-9,        1e-8,       5e-5, 9.9e-5,
          1.01e-4,    2e-4,       1e-3,       0.1,        1.0,         kPi / 2,    2.0,  3.0,
          kPi - 1e-2, kPi - 1e-4, kPi - 1e-6, kPi - 1e-8, kPi - 1e-12, kPi - 1e-15};
}

/// Calls check(w) for rotation vectors of all angles about random axes and the coordinate axes.
template <class Check>
void for_rotation_vectors(const Check& check) {
  RandomStream random(11);
  for (const double angle : angles()) {
    for (int i = 0; i < 20; ++i) check(Vector3d(angle * random.unit_vector()));
    for (int i = 0; i < 3; ++i) check(Vector3d(angle * Vector3d::Unit(i)));
  }
}

Vector6d random_twist(RandomStream& random, double angle) {
  Vector6d twist;
  twist << angle * random.unit_vector(), random.normal3();
  return twist;
}

TEST(So3, SkewIsTheCrossProduct) {
  RandomStream random(1);
  for (int i = 0; i < 100; ++i) {
    const Vector3d a = random.normal3(), b = random.normal3();
    EXPECT_LT((skew(a) * b - a.cross(b)).norm(), 1e-14);
  }
}

TEST(So3, ExpIsARotation) {
  for_rotation_vectors([](const Vector3d& w) {
    const Matrix3d R = exp_so3(w);
    EXPECT_LT((R * R.transpose() - Matrix3d::Identity()).norm(), 1e-14);
    EXPECT_NEAR(R.determinant(), 1, 1e-14);
    EXPECT_LT((R * w - w).norm(), 1e-14);
  });
}

TEST(So3, ExpAgreesWithTheMatrixExponential) {
  for_rotation_vectors([](const Vector3d& w) {
    const Matrix3d expected = skew(w).exp();
    EXPECT_LT((exp_so3(w) - expected).norm(), 1e-13);
  });
}

TEST(So3, TinyRotationsKeepAllDigits) {
  const Vector3d w(1e-9, -2e-9, 3e-9);
  const Matrix3d R = exp_so3(w);
  EXPECT_DOUBLE_EQ((R(2, 1) - R(1, 2)) / 2, w.x());
  EXPECT_DOUBLE_EQ((R(0, 2) - R(2, 0)) / 2, w.y());
  EXPECT_DOUBLE_EQ((R(1, 0) - R(0, 1)) / 2, w.z());
}

TEST(So3, LogInvertsExp) {
  for_rotation_vectors([](const Vector3d& w) {
    const Vector3d back = log_so3(exp_so3(w));
    // Within rounding of pi both signs of the axis are the same rotation.
    const bool flipped = w.norm() > 3.14159265 && back.dot(w) < 0;
    const double error = flipped ? (back + w).norm() : (back - w).norm();
    EXPECT_LE(error, 1e-14 + 1e-14 * w.norm()) << "angle " << w.norm();
  });
}

TEST(So3, ExpInvertsLog) {
  RandomStream random(2);
  for (int i = 0; i < 2000; ++i) {
    const Matrix3d R = random.rotation();
    const Vector3d w = log_so3(R);
    EXPECT_LE(w.norm(), kPi + 1e-15);
    EXPECT_LT((exp_so3(w) - R).norm(), 1e-14);
  }
}

TEST(So3, LogOfHalfTurns) {
  for (int axis = 0; axis < 3; ++axis) {
    Matrix3d R = -Matrix3d::Identity();
    R(axis, axis) = 1;
    EXPECT_LT((log_so3(R).cwiseAbs() - kPi * Vector3d::Unit(axis)).norm(), 1e-14);
  }
}

TEST(So3, DistanceIsTheAngle) {
  RandomStream random(3);
  for (const double angle : angles()) {
    const Matrix3d a = random.rotation();
    const Matrix3d b = a * exp_so3(angle * random.unit_vector());
    EXPECT_NEAR(rotation_distance(a, b), angle, 1e-14);
    EXPECT_NEAR(rotation_distance(b, a), angle, 1e-14);
  }
}

TEST(Se3, ExpAgreesWithTheMatrixExponential) {
  RandomStream random(4);
  for (const double angle : angles()) {
    const Vector6d twist = random_twist(random, angle);
    Eigen::Matrix4d generator = Eigen::Matrix4d::Zero();
    generator.topLeftCorner<3, 3>() = skew(twist.head<3>());
    generator.topRightCorner<3, 1>() = twist.tail<3>();
    const Eigen::Matrix4d expected = generator.exp();
    EXPECT_LT((exp_se3(twist).matrix() - expected).norm(), 1e-12) << "angle " << angle;
  }
}

TEST(Se3, LogInvertsExp) {
  RandomStream random(5);
  for (const double angle : angles()) {
    if (angle > kPi - 1e-9) continue;  // the sign of the axis is open
    for (int i = 0; i < 20; ++i) {
      const Vector6d twist = random_twist(random, angle);
      EXPECT_LT((log_se3(exp_se3(twist)) - twist).norm(), 1e-13) << "angle " << angle;
    }
  }
}

TEST(Se3, ExpInvertsLogEvenAtPi) {
  RandomStream random(6);
  for (const double angle : angles()) {
    const Eigen::Isometry3d T = exp_se3(random_twist(random, angle));
    EXPECT_LT((exp_se3(log_se3(T)).matrix() - T.matrix()).norm(), 1e-13) << "angle " << angle;
  }
}

TEST(Se3, AdjointCarriesTwistsOver) {
  RandomStream random(7);
  for (const double angle : angles()) {
    const Eigen::Isometry3d T = exp_se3(random_twist(random, angle));
    const Vector6d x = random_twist(random, 0.7);
    const Eigen::Isometry3d expected = T * exp_se3(x) * T.inverse();
    EXPECT_LT((exp_se3(adjoint(T) * x).matrix() - expected.matrix()).norm(), 1e-12);
  }
}

TEST(Se3, AdjointIsAHomomorphism) {
  RandomStream random(8);
  for (int i = 0; i < 100; ++i) {
    const Eigen::Isometry3d A = exp_se3(random_twist(random, 2.0));
    const Eigen::Isometry3d B = exp_se3(random_twist(random, 1.0));
    EXPECT_LT((adjoint(A * B) - adjoint(A) * adjoint(B)).norm(), 1e-12);
  }
}

TEST(Se3, FrameWithZIsOrthonormal) {
  RandomStream random(9);
  std::vector<Vector3d> axes;
  for (int i = 0; i < 3; ++i) {
    axes.push_back(Vector3d::Unit(i));
    axes.push_back(-Vector3d::Unit(i));
  }
  for (int i = 0; i < 1000; ++i) axes.push_back(random.unit_vector());
  for (const Vector3d& axis : axes) {
    const Matrix3d frame = frame_with_z(axis);
    EXPECT_EQ(frame.col(2), axis);
    EXPECT_LT((frame.transpose() * frame - Matrix3d::Identity()).norm(), 1e-14);
    EXPECT_NEAR(frame.determinant(), 1, 1e-14);
  }
}

TEST(Se3, RowMajorRoundTrip) {
  RandomStream random(10);
  const Eigen::Isometry3d T = exp_se3(random_twist(random, 1.3));
  const auto values = pose_to_row_major(T);
  EXPECT_EQ(values[3], T.translation().x());
  EXPECT_EQ(values[1], T.linear()(0, 1));
  EXPECT_EQ(pose_from_row_major(values).matrix(), T.matrix());
}

TEST(Se3, PoseOfBadNumbersIsRefused) {
  const auto identity = pose_to_row_major(Eigen::Isometry3d::Identity());
  const auto refusal = [&](std::size_t index, double value) {
    auto values = identity;
    values[index] = value;
    return error_message([&] { pose_from_row_major(values); });
  };
  EXPECT_EQ(refusal(3, std::numeric_limits<double>::quiet_NaN()), "element 3 of a pose is nan");
  EXPECT_NE(refusal(3, std::numeric_limits<double>::infinity()), "");
  EXPECT_NE(refusal(0, 1.0001), "");
  EXPECT_NE(refusal(0, -1).find("determinant"), std::string::npos);  // a reflection
  EXPECT_NE(refusal(12, 0.5).find("0.5"), std::string::npos);
  EXPECT_EQ(refusal(0, 1 + 1e-8), "");
}

}  // namespace
}  // namespace palpate
