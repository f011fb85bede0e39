// SPDX-License-Identifier: Apache-2.0
#include "palpate/geometry/objects/shapes.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <utility>

#include "palpate/core/angle.hpp"
#include "palpate/core/error.hpp"
#include "palpate/geometry/mesh/mass_properties.hpp"
#include "palpate/geometry/query/mesh_query.hpp"

namespace palpate::geometry {
namespace {

/// Every edge belongs to two triangles that run along it in opposite directions.
bool closed_and_consistent(const TriangleMesh& mesh) {
  std::map<std::pair<int, int>, int> uses;
  for (const auto& t : mesh.triangles) {
    for (std::size_t k = 0; k < 3; ++k) ++uses[{t[k], t[(k + 1) % 3]}];
  }
  for (const auto& [edge, count] : uses) {
    if (count != 1 || !uses.contains({edge.second, edge.first})) return false;
  }
  return true;
}

int euler_characteristic(const TriangleMesh& mesh) {
  const auto triangles = static_cast<int>(mesh.triangles.size());
  return static_cast<int>(mesh.vertices.size()) - 3 * triangles / 2 + triangles;
}

TEST(Shapes, AreClosedSurfacesOfTheStatedSize) {
  const std::pair<TriangleMesh, Eigen::Vector3d> cases[] = {
      {mug_mesh(), {0.117, 0.092, 0.081}},
      {bottle_mesh(), {0.096, 0.066, 0.190}},
      {box_mesh({0.050, 0.094, 0.175}), {0.050, 0.094, 0.175}},
      {bracket_mesh(), {0.120, 0.080, 0.040}}};
  for (const auto& [mesh, size] : cases) {
    EXPECT_TRUE(closed_and_consistent(mesh));
    EXPECT_LT((bounds(mesh).sizes() - size).norm(), 1e-4) << bounds(mesh).sizes().transpose();
    EXPECT_LE(mesh.triangles.size(), 8000u);
  }
}

TEST(Shapes, OnlyTheMugHasAHandle) {
  EXPECT_EQ(euler_characteristic(mug_mesh()), 0);
  EXPECT_EQ(euler_characteristic(bottle_mesh()), 2);
  EXPECT_EQ(euler_characteristic(box_mesh({1, 1, 1})), 2);
  EXPECT_EQ(euler_characteristic(bracket_mesh()), 2);
}

TEST(Shapes, MugHasTheVolumeOfItsWallAndHandle) {
  const double cup = kPi * (46.0 * 46 * 81 - 42.0 * 42 * 77);
  const double path = 72.9;  // length of the tube's superelliptic axis, by quadrature
  EXPECT_NEAR(mass_properties(mug_mesh(), 1).volume * 1e9, cup + kPi * 6.5 * 4 * path, 0.015 * cup);
  EXPECT_LT(std::abs(mass_properties(mug_mesh(), 1).centroid.y()), 1e-5);
  EXPECT_GT(mass_properties(mug_mesh(), 1).centroid.x(), 0.002);
}

TEST(Shapes, MugsHandleIsFiftyFiveMillimetresHigh) {
  Eigen::AlignedBox3d handle;
  for (const Eigen::Vector3d& v : mug_mesh().vertices) {
    if (v.x() > 0.0461) handle.extend(v);
  }
  EXPECT_NEAR(handle.sizes().z(), 0.055, 0.001);
  EXPECT_NEAR(handle.sizes().y(), 0.013, 0.001);
}

TEST(Shapes, BracketIsTwoPlates) {
  EXPECT_NEAR(mass_properties(bracket_mesh(), 1).volume, 0.040 * (0.12 * 0.02 + 0.06 * 0.02),
              1e-12);
}

TEST(Shapes, DuckStandsHasConcavitiesAndIsNoMirrorImageOfItself) {
  const TriangleMesh duck = duck_mesh();
  EXPECT_TRUE(closed_and_consistent(duck));
  EXPECT_EQ(euler_characteristic(duck), 2);
  EXPECT_LE(duck.triangles.size(), 8000u);
  EXPECT_LT((bounds(duck).sizes() - Eigen::Vector3d(0.099, 0.066, 0.083)).norm(), 1e-3);
  EXPECT_NEAR(bounds(duck).min().z(), 0, 1e-9);
  double deepest = 0, farthest = 0;
  const MeshQuery query(duck);
  for (const Eigen::Vector3d& v : duck.vertices) {
    // Between head and tail there is nothing, and a mirrored head or wing is elsewhere.
    deepest = std::max(deepest, query.signed_distance((v + duck.vertices.front()) / 2));
    farthest = std::max(farthest, query.signed_distance({v.x(), -v.y(), v.z()}));
  }
  EXPECT_GT(deepest, 0.005);
  EXPECT_GT(farthest, 0.005);
}

TEST(Shapes, BoxRefusesAnEdgeThatIsNotPositive) {
  EXPECT_THROW(box_mesh({0.1, 0, 0.1}), BadInput);
  EXPECT_THROW(box_mesh({0.1, -1, 0.1}), BadInput);
}

TEST(LowestPoint, IsOfTheMovedMesh) {
  const TriangleMesh box = box_mesh({0.2, 0.4, 0.6});
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  EXPECT_DOUBLE_EQ(lowest_point(T, box), -0.3);
  T.translation().z() = 1;
  T.linear() << 1, 0, 0, 0, 0, -1, 0, 1, 0;  // y becomes z
  EXPECT_DOUBLE_EQ(lowest_point(T, box), 0.8);
}

}  // namespace
}  // namespace palpate::geometry
