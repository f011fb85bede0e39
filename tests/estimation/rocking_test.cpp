// SPDX-License-Identifier: Apache-2.0
#include "estimation/rocking.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "palpate/core/angle.hpp"

namespace palpate::estimation {
namespace {

const Eigen::Vector3d kUp = Eigen::Vector3d::UnitZ();

/// Sigma of the tilt about an axis, rad.
double tilt(const Matrix6d& covariance, const Eigen::Vector3d& axis) {
  return std::sqrt(axis.dot(covariance.topLeftCorner<3, 3>() * axis));
}

/// A box that stands on its face of the two last sizes' product.
geometry::KnownObject box(const Eigen::Vector3d& size, double mass) {
  geometry::TriangleMesh mesh = geometry::load_known_object("box").mesh;
  const Eigen::Vector3d corner = mesh.vertices.front().cwiseAbs();  // of a box about its centroid
  for (auto& vertex : mesh.vertices) {
    vertex = (0.5 * size.array() * vertex.array() / corner.array()).matrix();
  }
  return geometry::make_known_object("box", mesh, mass);
}

/// How it lies: its axis, z, along x of the world.
Eigen::Isometry3d lying() {
  return Eigen::Isometry3d(Eigen::AngleAxisd(90 * kDegree, Eigen::Vector3d::UnitY()));
}

TEST(Rocking, ALyingBottleRollsAboutItsAxisAndItsCentroidWithIt) {
  const auto bottle = geometry::load_known_object("bottle");
  const Matrix6d covariance = rocking_covariance(bottle, lying(), kUp);
  const double roll = tilt(covariance, Eigen::Vector3d::UnitX());
  EXPECT_GT(roll, 1 * kDegree);
  EXPECT_LT(tilt(covariance, Eigen::Vector3d::UnitY()), 0.1 * roll);
  EXPECT_EQ(tilt(covariance, kUp), 0);
  EXPECT_GT(covariance(4, 4), std::pow(0.02 * roll, 2));  // by its radius, some 35 mm
  EXPECT_NEAR(covariance(5, 5), 0, 1e-12);
}

TEST(Rocking, AWideOrHeavyObjectTiltsLess) {
  const auto pose = Eigen::Isometry3d::Identity();
  const auto about_x = [&](const Eigen::Vector3d& size, double mass) {
    return tilt(rocking_covariance(box(size, mass), pose, kUp), Eigen::Vector3d::UnitX());
  };
  const double narrow = about_x({0.08, 0.02, 0.1}, 0.05);
  EXPECT_GT(narrow, 0.3 * kDegree);
  EXPECT_LT(about_x({0.08, 0.08, 0.1}, 0.05), 0.5 * narrow);
  EXPECT_LT(about_x({0.08, 0.02, 0.1}, 0.5), 0.2 * narrow);
}

TEST(Rocking, TurnsWithTheFrame) {
  const auto bottle = geometry::load_known_object("bottle");
  const Eigen::Matrix3d turn = (Eigen::AngleAxisd(0.7, Eigen::Vector3d::UnitX()) *
                                Eigen::AngleAxisd(-0.4, Eigen::Vector3d::UnitY()))
                                   .toRotationMatrix();
  const Eigen::Isometry3d pose = Eigen::Isometry3d(turn) * lying();
  const Matrix6d turned = rocking_covariance(bottle, pose, turn * kUp);
  EXPECT_NEAR(tilt(turned, turn * Eigen::Vector3d::UnitX()),
              tilt(rocking_covariance(bottle, lying(), kUp), Eigen::Vector3d::UnitX()),
              0.02 * kDegree);
}

}  // namespace
}  // namespace palpate::estimation
