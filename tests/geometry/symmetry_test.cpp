// SPDX-License-Identifier: Apache-2.0
#include "geometry/objects/symmetry.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "geometry/test_meshes.hpp"
#include "palpate/core/error.hpp"
#include "palpate/core/random.hpp"
#include "palpate/core/se3.hpp"
#include "palpate/geometry/mesh/mass_properties.hpp"
#include "palpate/geometry/objects/shapes.hpp"

namespace palpate::geometry {
namespace {

using Rotations = std::vector<Eigen::Matrix3d>;

Rotations symmetries_of(const TriangleMesh& mesh) {
  return rotational_symmetries(mesh, mass_properties(mesh, 1).centroid);
}

double distance_to(const Rotations& set, const Eigen::Matrix3d& R) {
  double least = std::numbers::pi;
  for (const Eigen::Matrix3d& other : set) least = std::min(least, rotation_distance(other, R));
  return least;
}

void expect_group(const Rotations& set) {
  EXPECT_EQ(set.front(), Eigen::Matrix3d::Identity());
  for (const Eigen::Matrix3d& a : set) {
    EXPECT_LT(distance_to(set, a.transpose()), 1e-6);
    for (const Eigen::Matrix3d& b : set) EXPECT_LT(distance_to(set, a * b), 1e-6);
  }
}

TriangleMesh turned(const TriangleMesh& mesh, RandomStream& random, Eigen::Matrix3d& R) {
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.linear() = R = random.rotation();
  T.translation() = 0.1 * random.normal3();
  return transformed(T, mesh);
}

TEST(Symmetry, OrdersOfTheBuiltInShapes) {
  EXPECT_EQ(symmetries_of(mug_mesh()).size(), 1u);
  EXPECT_EQ(symmetries_of(bottle_mesh()).size(), 2u);
  EXPECT_EQ(symmetries_of(box_mesh({0.050, 0.094, 0.175})).size(), 4u);
  // Legs of different lengths: only a reflection keeps the L, and that is no rotation.
  EXPECT_EQ(symmetries_of(bracket_mesh()).size(), 1u);
}

TEST(Symmetry, BottleTurnsByHalfAboutItsAxis) {
  const Rotations group = symmetries_of(bottle_mesh());
  ASSERT_EQ(group.size(), 2u);
  const Eigen::Matrix3d half = Eigen::Vector3d(-1, -1, 1).asDiagonal();
  EXPECT_LT(rotation_distance(group[1], half), 1e-3);
  expect_group(group);
}

TEST(Symmetry, GroupsOfBoxesInAnyPose) {
  RandomStream random(1, "symmetry");
  const std::pair<Eigen::Vector3d, std::size_t> cases[] = {
      {{0.05, 0.09, 0.17}, 4}, {{0.06, 0.06, 0.12}, 8}, {{0.07, 0.07, 0.07}, 24}};
  for (const auto& [size, order] : cases) {
    Eigen::Matrix3d R;
    const Rotations group = symmetries_of(turned(box_mesh(size), random, R));
    EXPECT_EQ(group.size(), order) << size.transpose();
    expect_group(group);
    for (int axis = 0; axis < 3; ++axis) {
      const Eigen::Matrix3d half =
          Eigen::AngleAxisd(std::numbers::pi, R.col(axis)).toRotationMatrix();
      EXPECT_LT(distance_to(group, half), 0.02);
    }
  }
}

TEST(Symmetry, RevolutionIsEveryTwoDegreesAndFlipped) {
  RandomStream random(2, "symmetry");
  Eigen::Matrix3d R;
  const TriangleMesh torus = turned(testing::torus_mesh(0.05, 0.015, 64, 24), random, R);
  const Rotations group = symmetries_of(torus);
  ASSERT_EQ(group.size(), 360u);
  EXPECT_EQ(group.front(), Eigen::Matrix3d::Identity());
  int turns = 0;
  for (const Eigen::Matrix3d& g : group) {
    EXPECT_GT(std::abs(R.col(2).dot(g * R.col(2))), 1 - 1e-4);
    turns += R.col(2).dot(g * R.col(2)) > 0;
  }
  EXPECT_EQ(turns, 180);
  const Eigen::Matrix3d step =
      Eigen::AngleAxisd(2 * std::numbers::pi / 180, R.col(2)).toRotationMatrix();
  EXPECT_LT(distance_to(group, step), 0.005);
}

TEST(Symmetry, ASmallKnobBreaksARevolution) {
  // The handle is a few percent of the surface: only the quantile near 1 sees it.
  TriangleMesh knob = box_mesh({0.016, 0.016, 0.016});
  for (Eigen::Vector3d& v : knob.vertices) v.x() += 0.065;
  const TriangleMesh ring = testing::torus_mesh(0.05, 0.015, 64, 24);
  EXPECT_GT(area(ring), 15 * area(knob));
  const Rotations group = symmetries_of(testing::joined(ring, knob));
  EXPECT_EQ(group.size(), 2u);  // half a turn about the knob's own axis
  expect_group(group);
}

TEST(Symmetry, ABallIsCoveredToWithinFewDegrees) {
  const Rotations covering = symmetries_of(testing::torus_mesh(1e-9, 0.04, 64, 64));
  ASSERT_GT(covering.size(), 1000u);
  EXPECT_EQ(covering.front(), Eigen::Matrix3d::Identity());
  RandomStream random(3, "symmetry");
  for (int i = 0; i < 50; ++i) {
    EXPECT_LT(distance_to(covering, random.rotation()), 12 * std::numbers::pi / 180);
  }
}

TEST(Symmetry, SmallObjectsAreHeldToTighterTolerances) {
  EXPECT_EQ(symmetries_of(box_mesh({0.006, 0.010, 0.016})).size(), 4u);
}

TEST(Symmetry, RefusesBadInput) {
  EXPECT_THROW(rotational_symmetries({}, Eigen::Vector3d::Zero()), BadInput);
  EXPECT_THROW(rotational_symmetries(mug_mesh(), Eigen::Vector3d::Zero(), {.mean = 0}), BadInput);
}

}  // namespace
}  // namespace palpate::geometry
