// SPDX-License-Identifier: Apache-2.0
#include "simulation/world/decimation.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "palpate/geometry/mesh/sampling.hpp"
#include "palpate/geometry/objects/known_object.hpp"
#include "palpate/geometry/query/mesh_query.hpp"
#include "palpate/geometry/repair/mesh_repair.hpp"

namespace palpate::simulation {
namespace {

constexpr double kError = 0.0004;

geometry::TriangleMesh fine_mesh() { return geometry::load_known_object("generated:413").mesh; }

TEST(Decimated, IsWatertightOfFewerTrianglesAndHasTheSameVolume) {
  const auto fine = fine_mesh();
  ASSERT_GT(fine.triangles.size(), 20000U);
  const auto coarse = decimated(fine, 3000, kError);
  EXPECT_LE(coarse.triangles.size(), fine.triangles.size() / 2);
  const auto report = geometry::inspect(coarse);
  EXPECT_TRUE(report.watertight);
  EXPECT_NEAR(report.volume / geometry::inspect(fine).volume, 1, 0.01);
}

TEST(Decimated, StaysNearTheSurface) {
  const auto fine = fine_mesh();
  const geometry::MeshQuery surface(fine);
  const auto coarse = decimated(fine, 3000, kError);
  double square = 0;
  const auto samples = geometry::sample_surface(coarse, 2000, RandomStream(1));
  for (const auto& sample : samples) {
    const double distance = surface.closest_point(sample.point).distance;
    square += distance * distance / static_cast<double>(samples.size());
  }
  EXPECT_LT(std::sqrt(square), kError);
}

TEST(Decimated, LeavesAMeshThatIsCoarseEnough) {
  const auto mesh = geometry::load_known_object("box").mesh;
  EXPECT_EQ(decimated(mesh, 3000, kError).vertices, mesh.vertices);
  EXPECT_EQ(decimated(mesh, mesh.triangles.size(), kError).triangles, mesh.triangles);
}

TEST(Decimated, KeepsFineTrianglesWhereFewerWouldBeTooFarOff) {
  const auto fine = fine_mesh();
  EXPECT_GT(decimated(fine, 100, 1e-6).triangles.size(), 100U);
}

}  // namespace
}  // namespace palpate::simulation
