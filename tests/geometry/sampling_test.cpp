// SPDX-License-Identifier: Apache-2.0
#include "palpate/geometry/mesh/sampling.hpp"

#include <gtest/gtest.h>

#include <map>

#include "geometry/test_meshes.hpp"
#include "palpate/core/error.hpp"
#include "palpate/geometry/query/mesh_query.hpp"

namespace palpate::geometry {
namespace {

using testing::box_mesh;
using testing::torus_mesh;

TEST(SampleSurface, PointsLieOnTheSurfaceWithItsNormal) {
  const TriangleMesh mesh = torus_mesh(0.04, 0.015, 40, 18);
  const MeshQuery query(mesh);
  for (const auto& [point, normal] : sample_surface(mesh, 500, RandomStream(3))) {
    EXPECT_LT(query.closest_point(point).distance, 1e-12);
    EXPECT_NEAR(normal.norm(), 1, 1e-12);
    EXPECT_NEAR(query.signed_distance(point + 1e-5 * normal), 1e-5, 1e-9);
  }
}

TEST(SampleSurface, EachFaceOfABoxGetsItsShare) {
  const std::size_t count = 2200;
  std::map<std::array<double, 3>, int> on_side;
  for (const auto& sample : sample_surface(box_mesh(1, 2, 3), count, RandomStream(4))) {
    const Eigen::Vector3d side = sample.normal.array().round();
    ++on_side[{side.x(), side.y(), side.z()}];
  }
  EXPECT_EQ(on_side.size(), 6U);  // areas 6, 3 and 2 of 22, each in two successive triangles
  for (const double sign : {-1.0, 1.0}) {
    EXPECT_NEAR((on_side[{sign, 0, 0}]), 600, 2);
    EXPECT_NEAR((on_side[{0, sign, 0}]), 300, 2);
    EXPECT_NEAR((on_side[{0, 0, sign}]), 200, 2);
  }
}

TEST(SampleSurface, IsUniformWithinATriangle) {
  TriangleMesh mesh;
  mesh.vertices = {{0, 0, 0}, {3, 0, 0}, {0, 3, 0}};
  mesh.triangles = {{0, 1, 2}};
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  const auto samples = sample_surface(mesh, 20000, RandomStream(5));
  for (const auto& sample : samples) mean += sample.point / 20000.0;
  EXPECT_LT((mean - Eigen::Vector3d(1, 1, 0)).norm(), 0.03);  // 4 standard errors of 0.7/sqrt(n)
}

TEST(SampleSurface, SameSeedSamePoints) {
  const TriangleMesh mesh = box_mesh(1, 2, 3);
  const auto first = sample_surface(mesh, 50, RandomStream(6));
  const auto again = sample_surface(mesh, 50, RandomStream(6));
  const auto other = sample_surface(mesh, 50, RandomStream(7));
  ASSERT_EQ(first.size(), 50U);
  for (std::size_t i = 0; i < first.size(); ++i) {
    EXPECT_EQ(first[i].point, again[i].point);
    EXPECT_NE(first[i].point, other[i].point);
  }
}

TEST(SampleSurface, SkipsTrianglesWithoutAreaAndRefusesNothing) {
  TriangleMesh mesh = box_mesh(1, 1, 1);
  mesh.triangles.insert(mesh.triangles.begin(), {0, 0, 1});
  mesh.triangles.push_back({2, 2, 2});
  for (const auto& sample : sample_surface(mesh, 200, RandomStream(8))) {
    EXPECT_NEAR(sample.normal.norm(), 1, 1e-12);
  }
  EXPECT_TRUE(sample_surface(mesh, 0, RandomStream(8)).empty());
  EXPECT_THROW(sample_surface(TriangleMesh{}, 10, RandomStream(8)), BadInput);
  mesh.triangles = {{0, 0, 1}};
  EXPECT_THROW(sample_surface(mesh, 10, RandomStream(8)), BadInput);
}

TEST(Simplified, IsCoarserAndStaysNearTheSurface) {
  const TriangleMesh fine = torus_mesh(0.04, 0.015, 120, 60);
  const double cell = 0.006;
  const TriangleMesh coarse = simplified(fine, cell);
  EXPECT_LT(coarse.triangles.size(), fine.triangles.size() / 4);
  EXPECT_GT(coarse.triangles.size(), 100U);
  EXPECT_NEAR(area(coarse), area(fine), 0.15 * area(fine));
  const MeshQuery query(fine);
  for (const auto& vertex : coarse.vertices) {
    EXPECT_LT(query.closest_point(vertex).distance, cell);
  }
}

TEST(Simplified, TinyCellsChangeNothing) {
  const TriangleMesh box = box_mesh(1, 2, 3);
  EXPECT_EQ(simplified(box, 0.01).triangles.size(), box.triangles.size());
  EXPECT_NEAR(area(simplified(box, 0.01)), 22, 1e-12);
  EXPECT_THROW(simplified(box, 0), BadInput);
}

}  // namespace
}  // namespace palpate::geometry
