// SPDX-License-Identifier: Apache-2.0
#include "geometry/objects/stable_poses.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>

#include "palpate/core/error.hpp"
#include "palpate/core/random.hpp"
#include "palpate/geometry/mesh/mass_properties.hpp"
#include "palpate/geometry/objects/shapes.hpp"
#include "palpate/geometry/query/mesh_query.hpp"

namespace palpate::geometry {
namespace {

const StablePoseOptions kPlain{.barrier = 0, .merge_angle_deg = 0, .min_probability = 0};

std::vector<StablePose> stable_poses_of(const TriangleMesh& mesh,
                                        const StablePoseOptions& options = {}) {
  return stable_poses(mesh, mass_properties(mesh, 1).centroid, options);
}

Eigen::Vector3d up(const StablePose& stable_pose) { return stable_pose.R_table_object.row(2); }

double total(const std::vector<StablePose>& stable_poses) {
  double sum = 0;
  for (const StablePose& stable_pose : stable_poses) sum += stable_pose.probability;
  return sum;
}

const StablePose& with_up(const std::vector<StablePose>& stable_poses,
                          const Eigen::Vector3d& direction) {
  return *std::ranges::max_element(stable_poses, {}, [&](const StablePose& stable_pose) {
    return up(stable_pose).dot(direction);
  });
}

/// Prism over a polygon in the xz plane, of width 2 about y = 0.
TriangleMesh prism_along_y(const std::vector<Eigen::Vector2d>& polygon) {
  TriangleMesh mesh;
  const int n = static_cast<int>(polygon.size());
  for (double y : {1.0, -1.0}) {
    for (const Eigen::Vector2d& p : polygon) mesh.vertices.emplace_back(p.x(), y, p.y());
  }
  for (int i = 0; i < n; ++i) {
    const int j = (i + 1) % n;
    mesh.triangles.push_back({i, n + j, j});
    mesh.triangles.push_back({i, n + i, n + j});
    if (i == 0 || j == 0) continue;
    mesh.triangles.push_back({0, i, j});
    mesh.triangles.push_back({n, n + j, n + i});
  }
  for (auto& t : mesh.triangles) std::swap(t[1], t[2]);
  return mesh;
}

/// Cylinder along z as a prism of `sides` sides.
TriangleMesh cylinder(double radius, double height, int sides) {
  std::vector<Eigen::Vector2d> circle;
  for (int i = 0; i < sides; ++i) {
    const double angle = 2 * std::numbers::pi * i / sides;
    circle.emplace_back(radius * std::cos(angle), radius * std::sin(angle));
  }
  TriangleMesh mesh = prism_along_y(circle);
  for (Eigen::Vector3d& v : mesh.vertices) v = Eigen::Vector3d(v.x(), -v.z(), v.y() * height / 2);
  return mesh;
}

TEST(StablePoses, BoxRestsOnSixFacesAsOftenAsRandomDirectionsMeetThem) {
  const TriangleMesh box = box_mesh({0.050, 0.094, 0.175});
  const auto stable_poses = stable_poses_of(box);
  ASSERT_EQ(stable_poses.size(), 6u);
  EXPECT_NEAR(total(stable_poses), 1, 1e-12);

  // Independent of solid angles: where do random rays from the centroid leave the box?
  const MeshQuery query(box);
  RandomStream random(3, "drops");
  constexpr int kDrops = 200000;
  std::array<int, 6> hits{};
  for (int i = 0; i < kDrops; ++i) {
    const Eigen::Vector3d down = random.unit_vector();
    const auto hit = query.raycast(Eigen::Vector3d::Zero(), down, 1);
    ASSERT_TRUE(hit);
    const Eigen::Vector3d p = hit->distance * down;
    for (std::size_t k = 0; k < 6; ++k) {
      const double height = up(stable_poses[k]).dot(-p);
      if (std::abs(height - stable_poses[k].height) < 1e-9) ++hits[k];
    }
  }
  for (std::size_t k = 0; k < 6; ++k) {
    const double p = stable_poses[k].probability;
    EXPECT_NEAR(static_cast<double>(hits[k]) / kDrops, p, 4.5 * std::sqrt(p * (1 - p) / kDrops));
  }
}

TEST(StablePoses, OverhangingFacetsRollOntoTheirNeighbours) {
  // A leaning prism: standing on its base (z = 0) or its top, it topples; the sides catch it.
  const TriangleMesh leaning = prism_along_y({{0, 0}, {1, 0}, {5, 3}, {4, 3}});
  const auto stable_poses = stable_poses_of(leaning, kPlain);
  const MassProperties properties = mass_properties(leaning, 1);
  ASSERT_GT(properties.volume, 0);
  EXPECT_EQ(stable_poses.size(), 4u);
  EXPECT_NEAR(total(stable_poses), 1, 1e-12);
  EXPECT_LT(std::abs(up(with_up(stable_poses, {0, 0, 1})).z()), 0.99);

  // The base rolls over its right edge onto the lower side, whose down vector is (3, 0, -4) / 5.
  const MeshQuery query(leaning);
  RandomStream random(4, "drops");
  constexpr int kDrops = 100000;
  int expected = 0;
  for (int i = 0; i < kDrops; ++i) {
    const Eigen::Vector3d down = random.unit_vector();
    const auto hit = query.raycast(properties.centroid, down, 10);
    ASSERT_TRUE(hit);
    const Eigen::Vector3d p = properties.centroid + hit->distance * down;
    const bool on_base = std::abs(p.z()) < 1e-9;
    const bool on_lower_side = std::abs(3 * (p.x() - 1) - 4 * p.z()) < 1e-9;
    expected += on_base || on_lower_side;
  }
  const StablePose& side = with_up(stable_poses, Eigen::Vector3d(-3, 0, 4) / 5);
  EXPECT_GT(up(side).dot(Eigen::Vector3d(-3, 0, 4) / 5), 1 - 1e-9);
  EXPECT_NEAR(side.probability, static_cast<double>(expected) / kDrops, 0.007);
}

TEST(StablePoses, LayTheObjectOnTheTable) {
  for (const TriangleMesh& mesh : {mug_mesh(), bottle_mesh(), bracket_mesh()}) {
    const MassProperties properties = mass_properties(mesh, 1);
    const auto stable_poses = stable_poses_of(mesh);
    EXPECT_NEAR(total(stable_poses), 1, 1e-12);
    EXPECT_TRUE(std::ranges::is_sorted(stable_poses, std::greater{}, &StablePose::probability));
    for (const StablePose& stable_pose : stable_poses) {
      const Eigen::Matrix3d& R = stable_pose.R_table_object;
      EXPECT_LT((R * R.transpose() - Eigen::Matrix3d::Identity()).norm(), 1e-12);
      EXPECT_GT(R.determinant(), 0);
      double lowest = 1;
      Eigen::AlignedBox2d footprint;
      for (const Eigen::Vector3d& v : mesh.vertices) {
        const Eigen::Vector3d p = R * (v - properties.centroid);
        lowest = std::min(lowest, p.z());
        if (p.z() < -stable_pose.height + 1e-4) footprint.extend(Eigen::Vector2d(p.head<2>()));
      }
      EXPECT_NEAR(lowest, -stable_pose.height, 1e-6);
      EXPECT_TRUE(footprint.contains(Eigen::Vector2d(0, 0)));
    }
  }
}

TEST(StablePoses, AMugLiesOnItsHandle) {
  const auto stable_poses = stable_poses_of(mug_mesh());
  ASSERT_EQ(stable_poses.size(), 4u);  // upright, upside down, and on either side of the handle
  EXPECT_GT(up(with_up(stable_poses, {0, 0, 1})).z(), 0.999);
  EXPECT_GT(up(with_up(stable_poses, {0, 0, -1})).dot(Eigen::Vector3d(0, 0, -1)), 0.999);
  for (double side : {-1.0, 1.0}) {
    const StablePose& lying = with_up(stable_poses, {-0.5, side, 0});
    EXPECT_LT(up(lying).x(), -0.3);
    EXPECT_NEAR(up(lying).z(), 0, 0.02);
  }
}

TEST(StablePoses, ACanLiesOnAnyOfItsSidesSpreadEvenly) {
  const auto stable_poses = stable_poses_of(cylinder(0.034, 0.101, 96));
  EXPECT_LE(stable_poses.size(), 24u);
  EXPECT_NEAR(total(stable_poses), 1, 1e-12);
  std::vector<double> angles;
  for (const StablePose& stable_pose : stable_poses) {
    if (std::abs(up(stable_pose).z()) > 0.5) {
      EXPECT_NEAR(stable_pose.height, 0.0505, 1e-9);
      continue;
    }
    angles.push_back(std::atan2(up(stable_pose).y(), up(stable_pose).x()));
  }
  ASSERT_GE(angles.size(), 12u);
  std::ranges::sort(angles);
  for (std::size_t i = 0; i < angles.size(); ++i) {
    const double next = i + 1 < angles.size() ? angles[i + 1] : angles[0] + 2 * std::numbers::pi;
    EXPECT_LT(next - angles[i], 45 * std::numbers::pi / 180);
  }
  // Ends: two spherical caps of half angle atan(34 / 50.5).
  const double ends = 1 - std::cos(std::atan(0.034 / 0.0505));
  EXPECT_NEAR(2 * with_up(stable_poses, {0, 0, 1}).probability, ends, 0.002);
}

TEST(StablePoses, RotateWithTheMesh) {
  RandomStream random(5, "turns");
  const auto still = stable_poses_of(bracket_mesh());
  for (int trial = 0; trial < 5; ++trial) {
    Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
    T.linear() = random.rotation();
    T.translation() = random.normal3();
    const auto turned = stable_poses_of(transformed(T, bracket_mesh()));
    ASSERT_EQ(turned.size(), still.size());
    for (const StablePose& stable_pose : still) {
      const StablePose& same = with_up(turned, T.linear() * up(stable_pose));
      EXPECT_NEAR(same.probability, stable_pose.probability, 1e-9);
      EXPECT_NEAR(same.height, stable_pose.height, 1e-9);
    }
  }
}

TEST(StablePoses, LeavesOutRareStablePoses) {
  const TriangleMesh tall = box_mesh({0.02, 0.1, 0.3});
  EXPECT_EQ(stable_poses_of(tall, kPlain).size(), 6u);
  const auto common = stable_poses_of(tall);
  EXPECT_EQ(common.size(), 4u);
  EXPECT_NEAR(total(common), 1, 1e-12);
  EXPECT_EQ(stable_poses_of(tall, {.max_stable_poses = 2}).size(), 2u);
}

TEST(StablePoses, RefuseFlatMeshesAndBadOptions) {
  TriangleMesh flat;
  flat.vertices = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}, {0.5, 0.5, 0}};
  flat.triangles = {{0, 1, 2}, {1, 3, 2}};
  EXPECT_THROW(stable_poses(flat, Eigen::Vector3d::Zero()), BadInput);
  EXPECT_THROW(stable_poses_of(mug_mesh(), {.max_stable_poses = 0}), BadInput);
  EXPECT_THROW(stable_poses_of(mug_mesh(), {.min_probability = 1}), BadInput);
}

}  // namespace
}  // namespace palpate::geometry
