// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

#include "palpate/core/random.hpp"
#include "palpate/geometry/objects/known_object.hpp"
#include "palpate/geometry/query/capsule_collider.hpp"
#include "simulation/fine_meshes.hpp"

namespace palpate::simulation {
namespace {

using geometry::Capsule;
using geometry::CapsuleCollider;
using geometry::MeshQuery;

constexpr double kRadius = 0.007;  // m
constexpr double kHalf = 0.009;    // m, of a fingertip's axis

const MeshQuery& bumpy() {
  static const MeshQuery mesh(bumpy_ball(50200));
  return mesh;
}

/// A fingertip across the given direction, its axis `height` from the center.
Capsule tip_above(const Eigen::Vector3d& out, double height, const Eigen::Vector3d& along) {
  const Eigen::Vector3d half = kHalf * out.cross(along).normalized();
  return {height * out - half, height * out + half, kRadius};
}

/// Least signed distance of the mesh along the axis, by looking at many places of it.
double distance_of_axis(const MeshQuery& mesh, const Capsule& tip) {
  double least = 1;
  for (int i = 0; i <= 400; ++i) {
    least = std::min(least, mesh.signed_distance(tip.a + i / 400.0 * (tip.b - tip.a)));
  }
  return least;
}

TEST(FineMesh, HasFiftyThousandTriangles) {
  EXPECT_NEAR(static_cast<double>(bumpy().mesh().triangles.size()), 50000, 500);
}

TEST(FineMesh, DeepestContactIsExact) {
  const CapsuleCollider collider(bumpy());
  RandomStream random(1);
  int met = 0;
  for (int trial = 0; trial < 60; ++trial) {
    const Capsule tip =
        tip_above(random.unit_vector(), random.uniform(0.045, 0.052), random.unit_vector());
    const double expected = distance_of_axis(bumpy(), tip) - kRadius;
    if (expected < -kRadius) continue;  // the axis itself is inside
    const auto contacts = collider.contacts(tip, 0.002, 2);
    if (expected > 0.0019) continue;
    ASSERT_FALSE(contacts.empty());
    ++met;
    EXPECT_NEAR(contacts.front().distance, expected, 2e-6);
    const auto surface = bumpy().closest_point(contacts.front().point);
    EXPECT_LT(surface.distance, 1e-9);
  }
  EXPECT_GT(met, 20);
}

TEST(FineMesh, DeepestContactIsExactOnTheMugsThinWalls) {
  const MeshQuery mesh(geometry::load_known_object("mug").mesh);
  const CapsuleCollider collider(mesh);
  RandomStream random(2);
  int met = 0;
  for (int trial = 0; trial < 150; ++trial) {
    const auto near = mesh.closest_point(0.06 * random.normal3());
    const Eigen::Vector3d center = near.point + random.uniform(0.005, 0.0068) * near.normal;
    const Eigen::Vector3d half = kHalf * random.unit_vector();
    const Capsule tip{center - half, center + half, kRadius};
    const double expected = distance_of_axis(mesh, tip);
    if (expected < 0) continue;  // the axis passes through the wall
    const auto contacts = collider.contacts(tip, 0, 2);
    ASSERT_FALSE(contacts.empty());
    ++met;
    EXPECT_NEAR(contacts.front().distance, expected - kRadius, 5e-5);  // the axis is sampled
  }
  EXPECT_GT(met, 30);
}

TEST(FineMesh, ATipBetweenTwoWallsMeetsBothWithOpposedNormals) {
  geometry::TriangleMesh walls = gridded_slab(3);
  const auto count = static_cast<int>(walls.vertices.size());
  const geometry::TriangleMesh slab = walls;
  for (const Eigen::Vector3d& v : slab.vertices) {
    walls.vertices.emplace_back(v + Eigen::Vector3d(0, 0, 0.02 + 2 * (kRadius - 0.0003)));
  }
  for (const auto& t : slab.triangles) {
    walls.triangles.push_back({t[0] + count, t[1] + count, t[2] + count});
  }
  const MeshQuery mesh(walls);
  const Eigen::Vector3d center(0.004, 0.007, kRadius - 0.0003), half(kHalf, 0, 0);
  const auto contacts =
      CapsuleCollider(mesh).contacts({center - half, center + half, kRadius}, 0, 2);
  ASSERT_EQ(contacts.size(), 2u);
  EXPECT_NEAR(contacts[0].normal.dot(contacts[1].normal), -1, 1e-12);
  for (const auto& contact : contacts) {
    EXPECT_NEAR(contact.distance, -0.0003, 1e-12);
    EXPECT_GT(contact.normal.dot(center - contact.point), 0);
  }
}

/// Largest step of depth and of normal (rad) of the deepest contact along a motion.
struct Jumps {
  double depth = 0, normal = 0;
  int lost = 0;
};

template <class Motion>
Jumps follow(const CapsuleCollider& collider, int steps, Motion motion) {
  Jumps jumps;
  std::optional<geometry::CapsuleContact> last;
  for (int i = 0; i <= steps; ++i) {
    const auto contacts = collider.contacts(motion(static_cast<double>(i) / steps), 0.001, 2);
    if (contacts.empty()) {
      ++jumps.lost;
      continue;
    }
    const geometry::CapsuleContact& now = contacts.front();
    if (last) {
      jumps.depth = std::max(jumps.depth, std::abs(now.distance - last->distance));
      const double turn =
          std::atan2(now.normal.cross(last->normal).norm(), now.normal.dot(last->normal));
      jumps.normal = std::max(jumps.normal, turn);
    }
    last = now;
  }
  return jumps;
}

TEST(FineMesh, SlidingOverAFaceOfManyTrianglesMeetsNoEdges) {
  const MeshQuery mesh(gridded_slab(60));
  const CapsuleCollider collider(mesh);
  const Jumps jumps = follow(collider, 2000, [](double s) {
    const Eigen::Vector3d center(-0.03 + 0.06 * s, 0.02 - 0.03 * s, kRadius - 0.0003);
    const Eigen::Vector3d half(kHalf * std::cos(3 * s), kHalf * std::sin(3 * s), 0);
    return Capsule{center - half, center + half, kRadius};
  });
  EXPECT_EQ(jumps.lost, 0);
  EXPECT_LT(jumps.depth, 1e-12);
  EXPECT_LT(jumps.normal, 1e-9);
}

TEST(FineMesh, RollingAboutAnEdgeTurnsTheNormalSteadily) {
  const MeshQuery mesh(gridded_slab(1));
  const CapsuleCollider collider(mesh);
  constexpr int kSteps = 1000;
  const Jumps jumps = follow(collider, kSteps, [](double s) {
    const double angle = 0.5 * std::numbers::pi * s;  // about the edge x = 0.05, z = 0
    const Eigen::Vector3d center =
        Eigen::Vector3d(0.05, 0, 0) +
        (kRadius - 0.0003) * Eigen::Vector3d(std::sin(angle), 0, std::cos(angle));
    const Eigen::Vector3d half(0, kHalf, 0);
    return Capsule{center - half, center + half, kRadius};
  });
  EXPECT_EQ(jumps.lost, 0);
  EXPECT_LT(jumps.depth, 1e-9);
  EXPECT_LT(jumps.normal, 1.01 * 0.5 * std::numbers::pi / kSteps);
}

TEST(FineMesh, DepthIsSteadyOverBumps) {
  const CapsuleCollider collider(bumpy());
  constexpr int kSteps = 1500;
  constexpr double kTurn = 1.5;  // rad, about the ball
  const Jumps jumps = follow(collider, kSteps, [](double s) {
    const Eigen::Vector3d out(std::cos(kTurn * s), std::sin(kTurn * s), 0.3);
    return tip_above(out.normalized(), 0.0455, Eigen::Vector3d::UnitZ());
  });
  EXPECT_EQ(jumps.lost, 0);
  // No point of the tip moves farther in a step than this, so neither does the depth change more.
  EXPECT_LT(jumps.depth, 1.05 * kTurn / kSteps * 0.06);
}

}  // namespace
}  // namespace palpate::simulation
