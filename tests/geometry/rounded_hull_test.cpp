// SPDX-License-Identifier: Apache-2.0
#include "palpate/geometry/query/rounded_hull.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "palpate/core/error.hpp"
#include "palpate/core/random.hpp"

namespace palpate::geometry {
namespace {

using Points = std::vector<Eigen::Vector3d>;

Points box(double x, double y, double z) {
  Points points;
  for (int i = 0; i < 8; ++i) {
    points.emplace_back(i & 1 ? x : -x, i & 2 ? y : -y, i & 4 ? z : -z);
  }
  return points;
}

Points random_points(int count, RandomStream& random) {
  Points points;
  for (int i = 0; i < count; ++i) points.emplace_back(0.01 * random.unit_vector());
  return points;
}

TEST(RoundedHull, OfABoxIsTheBoxWithRoundedEdges) {
  const auto hull = RoundedHull::within(box(0.006, 0.008, 0.012), 0.001);
  EXPECT_EQ(hull.corners().size(), 8u);
  EXPECT_EQ(hull.edges().size(), 12u);
  EXPECT_EQ(hull.facets().size(), 6u);
  for (const auto& corner : hull.corners()) {
    EXPECT_LT((corner.p.cwiseAbs() - Eigen::Vector3d(0.005, 0.007, 0.011)).norm(), 1e-9);
    EXPECT_EQ(corner.ways.size(), 3u);
  }
  EXPECT_NEAR(hull.above_facets({0.007, 0, 0}), 0.002, 1e-9);
}

TEST(RoundedHull, FacesAreThoseOfTheHullOfThePoints) {
  RandomStream random(1);
  for (int trial = 0; trial < 20; ++trial) {
    const Points points = random_points(30, random);
    const auto hull = RoundedHull::within(points, 0.001);
    double least = 1, most = 0;
    for (int i = 0; i < 500; ++i) {
      const Eigen::Vector3d way = random.unit_vector();
      double given = -1, rounded = -1;
      for (const auto& p : points) given = std::max(given, way.dot(p));
      for (const auto& corner : hull.corners()) {
        rounded = std::max(rounded, way.dot(corner.p) + hull.radius());
      }
      least = std::min(least, given - rounded);
      most = std::max(most, given - rounded);
    }
    EXPECT_GT(least, -2e-5) << "nothing stands out";
    EXPECT_LT(most, 0.0015) << "only corners are missing";
  }
}

TEST(RoundedHull, PointsOfItsSurfaceReachAsFarAsIt) {
  RandomStream random(3);
  const auto hull = RoundedHull::within(random_points(30, random), 0.001);
  for (const Eigen::Vector3d& p : hull.surface_points()) {
    EXPECT_NEAR((p - hull.nearest_in_core(p)).norm(), hull.radius(), 2e-5);
  }
}

TEST(RoundedHull, ACutEndsIt) {
  const auto hull = RoundedHull::within(box(0.006, 0.006, 0.03), 0.001,
                                        HalfSpace{-Eigen::Vector3d::UnitZ(), -0.01});
  double low = 1;
  for (const auto& corner : hull.corners()) low = std::min(low, corner.p.z() - hull.radius());
  EXPECT_NEAR(low, 0.01, 1e-9);
  EXPECT_THROW(RoundedHull::within(box(0.006, 0.006, 0.03), 0.001,
                                   HalfSpace{-Eigen::Vector3d::UnitZ(), -0.04}),
               BadInput);
}

TEST(RoundedHull, ThinBodiesGetSmallerEdges) {
  EXPECT_NEAR(RoundedHull::within(box(0.01, 0.01, 0.001), 0.002).radius(), 0.0005, 5e-5);
  EXPECT_THROW(RoundedHull::within(box(0.01, 0.01, 0), 0.002), BadInput);
  EXPECT_THROW(RoundedHull(box(0.01, 0.01, 0.01), 0), BadInput);
  EXPECT_THROW(RoundedHull(box(0.01, 0.01, 0.01), std::nan("")), BadInput);
}

TEST(RoundedHull, TheNearestPointOfTheCoreIsNotFartherThanAnyOther) {
  RandomStream random(2);
  const RoundedHull hull(random_points(40, random), 0.001);
  const Points grid = hull.spread_over_core(200, {0, 0, 0.02});
  for (int trial = 0; trial < 200; ++trial) {
    const Eigen::Vector3d p = 0.015 * random.unit_vector();
    const Eigen::Vector3d q = hull.nearest_in_core(p);
    EXPECT_LT(hull.above_facets(q), 1e-9);
    for (const Eigen::Vector3d& other : grid) {
      EXPECT_LE((p - q).norm(), (p - other).norm() + 1e-9);
    }
  }
  EXPECT_EQ(hull.nearest_in_core({0, 0, 0}), Eigen::Vector3d(0, 0, 0));
}

TEST(RoundedHull, PointsAreSpreadOverItsCoreFromTheOneThatIsNearest) {
  const RoundedHull hull(box(0.005, 0.005, 0.01), 0.001);
  const Points points = hull.spread_over_core(20, {0.005, 0.005, 0.02});
  ASSERT_EQ(points.size(), 20u);
  EXPECT_LT((points.front() - Eigen::Vector3d(0.005, 0.005, 0.01)).norm(), 1e-9);
  for (std::size_t i = 0; i < points.size(); ++i) {
    EXPECT_NEAR(hull.above_facets(points[i]), 0, 1e-9);
    for (std::size_t k = 0; k < i; ++k) EXPECT_GT((points[i] - points[k]).norm(), 0.003);
  }
}

}  // namespace
}  // namespace palpate::geometry
