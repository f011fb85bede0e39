// SPDX-License-Identifier: Apache-2.0
#include "palpate/geometry/mesh/mass_properties.hpp"

#include <gtest/gtest.h>

#include <numbers>

#include "geometry/test_meshes.hpp"
#include "palpate/core/error.hpp"
#include "palpate/core/random.hpp"
#include "palpate/geometry/objects/shapes.hpp"

namespace palpate::geometry {
namespace {

TEST(MassProperties, BoxMatchesTheClosedForm) {
  const double x = 0.05, y = 0.094, z = 0.175, mass = 0.4;
  const MassProperties p = mass_properties(box_mesh({x, y, z}), mass);
  EXPECT_NEAR(p.volume, x * y * z, 1e-15);
  EXPECT_LT(p.centroid.norm(), 1e-15);
  const Eigen::Vector3d diagonal(y * y + z * z, x * x + z * z, x * x + y * y);
  const Eigen::Matrix3d inertia = (mass / 12 * diagonal).asDiagonal();
  EXPECT_LT((p.inertia - inertia).norm(), 1e-12);
}

TEST(MassProperties, TorusMatchesTheClosedForm) {
  const double R = 0.05, r = 0.02, mass = 0.3;
  const MassProperties p = mass_properties(testing::torus_mesh(R, r, 240, 120), mass);
  EXPECT_NEAR(p.volume, 2 * std::pow(std::numbers::pi, 2) * R * r * r, 1e-3 * p.volume);
  EXPECT_NEAR(p.inertia(2, 2), mass * (R * R + 0.75 * r * r), 1e-3 * p.inertia(2, 2));
  EXPECT_NEAR(p.inertia(0, 0), mass * (R * R / 2 + 0.625 * r * r), 1e-3 * p.inertia(0, 0));
}

TEST(MassProperties, MovesWithTheMesh) {
  RandomStream random(1, "mass");
  const MassProperties still = mass_properties(mug_mesh(), 0.12);
  for (int trial = 0; trial < 10; ++trial) {
    Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
    T.linear() = random.rotation();
    T.translation() = 10 * random.normal3();
    const MassProperties moved = mass_properties(transformed(T, mug_mesh()), 0.12);
    EXPECT_NEAR(moved.volume, still.volume, 1e-9 * still.volume);
    EXPECT_LT((moved.centroid - T * still.centroid).norm(), 1e-9);
    const Eigen::Matrix3d turned = T.linear() * still.inertia * T.linear().transpose();
    EXPECT_LT((moved.inertia - turned).norm(), 1e-6 * still.inertia.norm());
  }
}

TEST(MassProperties, RefusesAMeshWithoutVolume) {
  TriangleMesh inside_out = box_mesh({1, 1, 1});
  for (auto& t : inside_out.triangles) std::swap(t[0], t[1]);
  EXPECT_THROW(mass_properties(inside_out, 1), BadInput);
  EXPECT_THROW(mass_properties({}, 1), BadInput);
}

}  // namespace
}  // namespace palpate::geometry
