// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>

#include "geometry/collider_meshes.hpp"
#include "palpate/core/random.hpp"
#include "palpate/core/se3.hpp"
#include "palpate/geometry/query/capsule_collider.hpp"

namespace palpate::geometry {
namespace {

constexpr double kRound = 0.001;

std::vector<Eigen::Vector3d> box(double x, double y, double z) {
  std::vector<Eigen::Vector3d> points;
  for (int i = 0; i < 8; ++i) {
    points.emplace_back(i & 1 ? x : -x, i & 2 ? y : -y, i & 4 ? z : -z);
  }
  return points;
}

/// A wedge like a fingertip of 40 vertices, and a box.
RoundedHull tip(int shape) {
  if (shape == 0) return {box(0.006, 0.007, 0.011), kRound};
  RandomStream random(7);
  std::vector<Eigen::Vector3d> points;
  for (int i = 0; i < 40; ++i) {
    points.emplace_back(Eigen::Vector3d(0.006, 0.008, 0.012).cwiseProduct(random.unit_vector()));
  }
  return {points, kRound};
}

Eigen::Isometry3d at(const Eigen::Vector3d& p, RandomStream& random) {
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  const Eigen::Vector3d axis = random.unit_vector();
  T.linear() = Eigen::AngleAxisd(random.uniform(0, 3.1), axis).toRotationMatrix();
  T.translation() = p;
  return T;
}

/// Distance between the core and the mesh by projections to and fro from many places.
double distance_by_projections(const RoundedHull& hull, const Eigen::Isometry3d& T_mesh_hull,
                               const MeshQuery& mesh) {
  double least = 1;
  for (const Eigen::Vector3d& start : hull.spread_over_core(25, {0, 0, 0.02})) {
    Eigen::Vector3d p = T_mesh_hull * start, q = p;
    for (int i = 0; i < 300; ++i) {
      q = mesh.closest_point(p).point;
      const Eigen::Vector3d next = T_mesh_hull * hull.nearest_in_core(T_mesh_hull.inverse() * q);
      if ((next - p).norm() < 1e-10) break;
      p = next;
    }
    least = std::min(least, (p - q).norm());
  }
  return least;
}

class HullContacts : public testing::TestWithParam<std::tuple<int, int>> {
 protected:
  MeshQuery mesh_{collider_mesh(std::get<0>(GetParam()))};
  CapsuleCollider collider_{mesh_};
  RoundedHull hull_ = tip(std::get<1>(GetParam()));

  bool core_is_outside(const Eigen::Isometry3d& T_mesh_hull) const {
    for (const Eigen::Vector3d& p : hull_.spread_over_core(100, {0, 0, 0})) {
      if (mesh_.signed_distance(T_mesh_hull * p) < 1e-5) return false;
    }
    return true;
  }
};

TEST_P(HullContacts, TheDeepestContactIsTheLeastDistanceBetweenCoreAndSurface) {
  RandomStream random(3);
  int tried = 0;
  for (int trial = 0; trial < 2000 && tried < 30; ++trial) {
    const auto T = at(near_surface(mesh_.mesh(), random.uniform(0.004, 0.013), random), random);
    if (!core_is_outside(T)) continue;
    const double distance = distance_by_projections(hull_, T, mesh_);
    if (distance > 0.0029 || distance < 1e-5) continue;
    ++tried;
    const auto contacts = collider_.contacts(hull_, T, 0.002, 8);
    ASSERT_FALSE(contacts.empty()) << trial << " at " << distance;
    const CapsuleContact& deepest = contacts.front();
    EXPECT_NEAR(deepest.distance, distance - kRound, 2e-6) << trial;
    EXPECT_LT(mesh_.closest_point(deepest.point).distance, 1e-9);
    const Eigen::Vector3d core = T * hull_.nearest_in_core(T.inverse() * deepest.point);
    EXPECT_LT((core - deepest.point).normalized().cross(deepest.normal).norm(), 1e-4) << trial;
  }
  EXPECT_GE(tried, 10);
}

TEST_P(HullContacts, AreOrderedDifferAndPointOutOfTheMesh) {
  RandomStream random(4);
  int found = 0;
  for (int trial = 0; trial < 300; ++trial) {
    const auto T = at(near_surface(mesh_.mesh(), random.uniform(0, 0.01), random), random);
    const auto contacts = collider_.contacts(hull_, T, 0, 4);
    ASSERT_LE(contacts.size(), 4u);
    for (const CapsuleContact& contact : contacts) {
      ++found;
      EXPECT_NEAR(contact.normal.norm(), 1, 1e-9);
      EXPECT_LT(contact.distance, 0);
      EXPECT_LT(mesh_.closest_point(contact.point).distance, 1e-9);
      EXPECT_LE(contacts.front().distance, contact.distance);
    }
  }
  EXPECT_GT(found, 100);
}

INSTANTIATE_TEST_SUITE_P(Shapes, HullContacts,
                         testing::Combine(testing::Values(0, 1, 2), testing::Values(0, 1)));

Eigen::Isometry3d lifted(double z) { return Eigen::Isometry3d(Eigen::Translation3d(0, 0, z)); }

TEST(HullContacts, LyingFlatABoxTouchesWithItsCorners) {
  const MeshQuery mesh(slab(0.2, 0.2, 0.04));
  const RoundedHull hull(box(0.006, 0.007, 0.011), kRound);
  const auto contacts =
      CapsuleCollider(mesh).contacts(hull, lifted(0.02 + 0.011 + kRound - 0.0002), 0, 4);
  ASSERT_EQ(contacts.size(), 4u);
  for (const CapsuleContact& contact : contacts) {
    EXPECT_LT((contact.normal - Eigen::Vector3d::UnitZ()).norm(), 1e-9);
    EXPECT_NEAR(contact.distance, -0.0002, 1e-9);
    EXPECT_NEAR(std::abs(contact.point.x()), 0.006, 1e-9);
    EXPECT_NEAR(std::abs(contact.point.y()), 0.007, 1e-9);
  }
}

TEST(HullContacts, ALargePadTouchesTheCornersOfASmallFace) {
  const MeshQuery mesh(slab(0.012, 0.016, 0.04));
  const RoundedHull hull(box(0.02, 0.02, 0.005), kRound);
  const auto contacts =
      CapsuleCollider(mesh).contacts(hull, lifted(0.02 + 0.005 + kRound - 0.0003), 0, 8);
  ASSERT_EQ(contacts.size(), 4u);
  for (const CapsuleContact& contact : contacts) {
    EXPECT_LT((contact.normal - Eigen::Vector3d::UnitZ()).norm(), 1e-6);
    EXPECT_NEAR(contact.distance, -0.0003, 1e-9);
    EXPECT_NEAR(std::abs(contact.point.x()), 0.006, 1e-9);
  }
}

TEST(HullContacts, CrossedEdgesTouchWhereTheyCross) {
  const MeshQuery mesh(slab(0.1, 0.1, 0.02));  // its edge along y at x = 0.05, z = 0.01
  const RoundedHull hull(box(0.005, 0.005, 0.02), kRound);
  const Eigen::Vector3d out = Eigen::Vector3d(1, 0, 1).normalized();
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  // An edge of the box lies along (1, 0, -1), and its two faces look away from the slab alike.
  const Eigen::Vector3d along = Eigen::Vector3d(1, 0, -1).normalized();
  T.linear().col(2) = along;
  T.linear().col(0) = (-out + Eigen::Vector3d::UnitY()).normalized();
  T.linear().col(1) = along.cross(T.linear().col(0));
  const Eigen::Vector3d corner = T.linear() * Eigen::Vector3d(0.005, 0.005, 0);
  const bool first = corner.dot(out) < -0.005;
  const Eigen::Vector3d edge =
      first ? corner : Eigen::Vector3d(T.linear() * Eigen::Vector3d(0.005, -0.005, 0));
  T.translation() = Eigen::Vector3d(0.05, 0, 0.01) + 0.0008 * out - edge;
  const auto contacts = CapsuleCollider(mesh).contacts(hull, T, 0, 4);
  ASSERT_EQ(contacts.size(), 1u);
  EXPECT_LT((contacts[0].point - Eigen::Vector3d(0.05, 0, 0.01)).norm(), 1e-9);
  EXPECT_LT((contacts[0].normal - out).norm(), 1e-9);
  EXPECT_NEAR(contacts[0].distance, 0.0008 - kRound, 1e-9);
}

TEST(HullContacts, SunkInDeeperThanItsEdgesItIsLedOut) {
  const MeshQuery mesh(slab(0.2, 0.2, 0.04));
  const RoundedHull hull(box(0.006, 0.007, 0.011), kRound);
  const auto contacts = CapsuleCollider(mesh).contacts(hull, lifted(0.02 + 0.011 - 0.0015), 0, 4);
  ASSERT_EQ(contacts.size(), 4u);
  for (const CapsuleContact& contact : contacts) {
    EXPECT_LT((contact.normal - Eigen::Vector3d::UnitZ()).norm(), 1e-9);
    EXPECT_NEAR(contact.distance, -0.0015 - kRound, 1e-9);
  }
}

TEST(HullContacts, ASharpCornerInAPadIsLedOut) {
  const MeshQuery mesh(slab(0.012, 0.016, 0.04));
  const RoundedHull hull(box(0.02, 0.02, 0.005), kRound);
  Eigen::Isometry3d T = lifted(0.02 + 0.005 - 0.0005);
  T.prerotate(Eigen::AngleAxisd(0.02, Eigen::Vector3d::UnitY()));
  const auto contacts = CapsuleCollider(mesh).contacts(hull, T, 0, 4);
  ASSERT_FALSE(contacts.empty());
  EXPECT_LT(contacts.front().distance, -0.0012);
  EXPECT_LT((contacts.front().normal - T.linear().col(2)).norm(), 1e-6);
}

TEST(HullContacts, OutOfReachOrWithoutRoomThereIsNone) {
  const MeshQuery mesh(slab(0.1, 0.1, 0.02));
  const CapsuleCollider collider(mesh);
  const RoundedHull hull(box(0.006, 0.007, 0.011), kRound);
  EXPECT_TRUE(collider.contacts(hull, lifted(0.0221), 0, 4).empty());
  EXPECT_EQ(collider.contacts(hull, lifted(0.0221), 0.001, 4).size(), 4u);
  EXPECT_TRUE(collider.contacts(hull, lifted(0.0219), 0, 0).empty());
}

}  // namespace
}  // namespace palpate::geometry
