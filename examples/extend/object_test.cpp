// SPDX-License-Identifier: Apache-2.0
// Add an object: a function that makes its mesh, and a test of what Palpate derives from it.
#include <gtest/gtest.h>

#include "palpate/geometry/objects/known_object.hpp"

namespace palpate::geometry {
namespace {

/// A wedge for a door, m: 120 long, 40 wide, and 50 high at its rear end.
TriangleMesh wedge_mesh() {
  constexpr double kLength = 0.12, kWidth = 0.04, kHeight = 0.05;
  TriangleMesh mesh;
  for (const double y : {0.0, kWidth}) {
    mesh.vertices.insert(mesh.vertices.end(), {{0, y, 0}, {kLength, y, 0}, {0, y, kHeight}});
  }
  mesh.triangles = {{0, 1, 2}, {3, 5, 4},   // the sides, counter-clockwise seen from outside
                    {0, 3, 4}, {0, 4, 1},   // below
                    {0, 2, 5}, {0, 5, 3},   // behind
                    {1, 4, 5}, {1, 5, 2}};  // the slope
  return mesh;
}

TEST(Wedge, IsWatertightAndMostOftenLiesOnItsSlope) {
  const KnownObject wedge = make_known_object("wedge", wedge_mesh(), 0.1);
  EXPECT_TRUE(wedge.repairs.empty()) << wedge.repairs.front();  // watertight, normals outwards
  EXPECT_NEAR(wedge.mass_properties.volume, 0.12 * 0.04 * 0.05 / 2, 1e-12);
  EXPECT_EQ(wedge.symmetries.size(), 1);  // its mirror plane is no rotation

  double sum = 0;
  for (const StablePose& pose : wedge.stable_poses) sum += pose.probability;
  EXPECT_NEAR(sum, 1, 1e-9);
  // Most often it lies on its slope, the largest face and the one nearest to the centroid.
  EXPECT_NEAR(wedge.stable_poses.front().height, 0.12 * 0.05 / 0.13 / 3, 1e-9);
}

}  // namespace
}  // namespace palpate::geometry
