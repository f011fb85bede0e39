// SPDX-License-Identifier: Apache-2.0
#include "palpate/geometry/query/capsule_collider.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "geometry/collider_meshes.hpp"
#include "palpate/core/random.hpp"

namespace palpate::geometry {
namespace {

constexpr double kRadius = 0.007;

Capsule ball(const Eigen::Vector3d& center) { return {center, center, kRadius}; }

class CapsuleColliderOf : public testing::TestWithParam<int> {
 protected:
  MeshQuery mesh_{collider_mesh(GetParam())};
  CapsuleCollider collider_{mesh_};
};

TEST_P(CapsuleColliderOf, ABallTouchesAtTheClosestPoint) {
  RandomStream random(1);
  for (int trial = 0; trial < 500; ++trial) {
    const Eigen::Vector3d center =
        near_surface(mesh_.mesh(), random.uniform(-0.003, kRadius), random);
    const double distance = mesh_.signed_distance(center);
    const ClosestPoint closest = mesh_.closest_point(center);
    const auto contacts = collider_.contacts(ball(center), 0, 4);
    ASSERT_FALSE(contacts.empty());
    EXPECT_NEAR(contacts[0].distance, distance - kRadius, 1e-12);
    const Eigen::Vector3d out = (center - closest.point) / distance;
    if (std::abs(distance) < 1e-6) continue;
    EXPECT_NEAR((center - contacts[0].point).norm(), std::abs(distance), 1e-12);
    // Several places may be equally close.
    if ((contacts[0].point - closest.point).norm() < 1e-9) {
      EXPECT_LT((contacts[0].normal - out).norm(), 1e-6);
    }
  }
}

TEST_P(CapsuleColliderOf, TheDeepestContactIsTheLeastDistanceAlongTheAxis) {
  RandomStream random(2);
  constexpr int kSamples = 1000;
  constexpr double kLength = 0.018;
  int tried = 0;
  for (int trial = 0; trial < 200; ++trial) {
    const Eigen::Vector3d middle =
        near_surface(mesh_.mesh(), random.uniform(0.001, kRadius), random);
    const Eigen::Vector3d half = 0.5 * kLength * random.unit_vector();
    double least = 1;
    for (int i = 0; i <= kSamples; ++i) {
      least = std::min(least, mesh_.signed_distance(middle + (2.0 * i / kSamples - 1) * half));
    }
    if (least < 1e-5) continue;  // the axis itself is inside
    ++tried;
    const auto contacts = collider_.contacts({middle - half, middle + half, kRadius}, 0, 4);
    ASSERT_FALSE(contacts.empty());
    EXPECT_NEAR(contacts[0].distance, least - kRadius, kLength / kSamples);
    EXPECT_LE(contacts[0].distance, least - kRadius + 1e-12);
  }
  EXPECT_GT(tried, 30);
}

TEST_P(CapsuleColliderOf, NormalsPointOutAndContactsAreOrdered) {
  RandomStream random(3);
  for (int trial = 0; trial < 300; ++trial) {
    const Eigen::Vector3d middle = near_surface(mesh_.mesh(), random.uniform(0, 0.006), random);
    const Eigen::Vector3d half = 0.009 * random.unit_vector();
    const auto contacts = collider_.contacts({middle - half, middle + half, kRadius}, 0.001, 2);
    EXPECT_LE(contacts.size(), 2u);
    for (const CapsuleContact& contact : contacts) {
      EXPECT_NEAR(contact.normal.norm(), 1, 1e-12);
      EXPECT_LT(contact.distance, 0.001);
      EXPECT_LT(mesh_.closest_point(contact.point).distance, 1e-9);
      EXPECT_LE(contacts[0].distance, contact.distance);
      EXPECT_FALSE(mesh_.inside(contact.point + 1e-5 * contact.normal));
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Shapes, CapsuleColliderOf, testing::Values(0, 1, 2));

TEST(CapsuleCollider, LyingFlatItTouchesWithBothEnds) {
  const MeshQuery mesh(slab(0.2, 0.2, 0.04));
  const double z = 0.02 + kRadius - 0.0002;
  const auto contacts =
      CapsuleCollider(mesh).contacts({{-0.01, 0.003, z}, {0.01, 0.003, z}, kRadius}, 0, 2);
  ASSERT_EQ(contacts.size(), 2u);
  EXPECT_NEAR((contacts[0].point - contacts[1].point).norm(), 0.02, 1e-12);
  for (const CapsuleContact& contact : contacts) {
    EXPECT_LT((contact.normal - Eigen::Vector3d::UnitZ()).norm(), 1e-12);
    EXPECT_NEAR(contact.distance, -0.0002, 1e-12);
  }
}

TEST(CapsuleCollider, InAnInnerCornerItTouchesBothWalls) {
  const MeshQuery mesh(bracket());
  const double d = kRadius - 0.0001;
  const auto contacts = CapsuleCollider(mesh).contacts(ball({d, d, 0.003}), 0, 2);
  ASSERT_EQ(contacts.size(), 2u);
  EXPECT_NEAR(contacts[0].normal.dot(contacts[1].normal), 0, 1e-9);
}

TEST(CapsuleCollider, TheFarSideOfAThinWallIsNotTouched) {
  const MeshQuery mesh(slab(0.1, 0.1, 0.001));
  const auto contacts = CapsuleCollider(mesh).contacts(ball({0.01, 0.02, 0.0005 + 0.004}), 0, 4);
  ASSERT_EQ(contacts.size(), 1u);
  EXPECT_LT((contacts[0].normal - Eigen::Vector3d::UnitZ()).norm(), 1e-12);
  EXPECT_NEAR(contacts[0].distance, 0.004 - kRadius, 1e-12);
}

TEST(CapsuleCollider, AnEndInsideIsLedOutTheShortestWay) {
  const MeshQuery mesh(slab(0.1, 0.1, 0.02));
  const auto contacts = CapsuleCollider(mesh).contacts(ball({0.01, 0.02, 0.008}), 0, 4);
  ASSERT_EQ(contacts.size(), 1u);
  EXPECT_LT((contacts[0].normal - Eigen::Vector3d::UnitZ()).norm(), 1e-12);
  EXPECT_NEAR(contacts[0].distance, -0.002 - kRadius, 1e-12);
}

TEST(CapsuleCollider, AcrossAnEdgeItTouchesTheEdge) {
  const MeshQuery mesh(slab(0.1, 0.1, 0.02));
  const Eigen::Vector3d edge(0.05, 0, 0.01), out = Eigen::Vector3d(1, 0, 1).normalized();
  const Eigen::Vector3d middle = edge + 0.0065 * out;
  const Eigen::Vector3d half = 0.009 * Eigen::Vector3d(1, 0, -1).normalized();
  const auto contacts =
      CapsuleCollider(mesh).contacts({middle - half, middle + half, kRadius}, 0, 2);
  ASSERT_FALSE(contacts.empty());
  EXPECT_LT((contacts[0].point - edge).norm(), 1e-9);
  EXPECT_LT((contacts[0].normal - out).norm(), 1e-9);
  EXPECT_NEAR(contacts[0].distance, 0.0065 - kRadius, 1e-12);
}

TEST(CapsuleCollider, OutOfReachOrWithoutRoomThereIsNoContact) {
  const MeshQuery mesh(slab(0.1, 0.1, 0.02));
  const CapsuleCollider collider(mesh);
  EXPECT_TRUE(collider.contacts(ball({0, 0, 0.0171}), 0, 4).empty());
  EXPECT_EQ(collider.contacts(ball({0, 0, 0.0171}), 0.001, 4).size(), 1u);
  EXPECT_TRUE(collider.contacts(ball({0, 0, 0.0165}), 0, 0).empty());
}

}  // namespace
}  // namespace palpate::geometry
