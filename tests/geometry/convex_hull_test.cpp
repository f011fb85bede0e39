// SPDX-License-Identifier: Apache-2.0
#include "geometry/mesh/convex_hull.hpp"

#include <gtest/gtest.h>

#include "palpate/core/error.hpp"

namespace palpate::geometry {
namespace {

TEST(HullCorners, AreThoseOfACubeWithoutWhatLiesInside) {
  std::vector<Eigen::Vector3d> points = {{0.1, 0.2, -0.3}, {0, 0, 0}};
  for (const double x : {-1.0, 1.0}) {
    for (const double y : {-1.0, 1.0}) {
      for (const double z : {-1.0, 1.0}) points.emplace_back(x, y, z);
    }
  }
  const auto corners = hull_corners(points);
  EXPECT_EQ(corners.size(), 8u);
  for (const auto& corner : corners) EXPECT_NEAR(corner.cwiseAbs().minCoeff(), 1, 1e-12);
}

TEST(HullCorners, NeedAVolume) {
  EXPECT_THROW(hull_corners({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}}), BadInput);
}

}  // namespace
}  // namespace palpate::geometry
