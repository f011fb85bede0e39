// SPDX-License-Identifier: Apache-2.0
#include "palpate/geometry/query/mesh_query.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <numbers>
#include <random>

#include "geometry/test_meshes.hpp"
#include "palpate/core/error.hpp"

namespace palpate::geometry {
namespace {

using testing::box_mesh;
using testing::joined;
using testing::torus_mesh;

/// Points in a box twice the size of the mesh's. (mt19937_64's values are fixed by the standard.)
std::vector<Eigen::Vector3d> points_around(const TriangleMesh& mesh, int count) {
  std::mt19937_64 bits(5);
  const auto uniform = [&bits] { return static_cast<double>(bits() >> 11) * 0x1p-53; };
  const auto box = bounds(mesh);
  std::vector<Eigen::Vector3d> points;
  for (int i = 0; i < count; ++i) {
    const Eigen::Vector3d at(2 * uniform() - 1, 2 * uniform() - 1, 2 * uniform() - 1);
    points.push_back(box.center() + at.cwiseProduct(box.sizes()));
  }
  return points;
}

/// Distance to a triangle by a method of its own: the plane where the foot lies inside, else edges.
double distance_to_triangle(const Eigen::Vector3d& p, const TriangleMesh& mesh, std::size_t i) {
  std::array<Eigen::Vector3d, 3> t;
  for (std::size_t k = 0; k < 3; ++k) {
    t[k] = mesh.vertices[static_cast<std::size_t>(mesh.triangles[i][k])];
  }
  const Eigen::Vector3d normal = (t[1] - t[0]).cross(t[2] - t[0]).normalized();
  bool over_face = true;
  double nearest = std::numeric_limits<double>::infinity();
  for (std::size_t k = 0; k < 3; ++k) {
    const Eigen::Vector3d edge = t[(k + 1) % 3] - t[k], to = p - t[k];
    over_face = over_face && normal.dot(edge.cross(to)) >= 0;
    const double s = std::clamp(to.dot(edge) / edge.squaredNorm(), 0.0, 1.0);
    nearest = std::min(nearest, (to - s * edge).norm());
  }
  return over_face ? std::abs(normal.dot(p - t[0])) : nearest;
}

double brute_force_distance(const Eigen::Vector3d& p, const TriangleMesh& mesh) {
  double nearest = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    nearest = std::min(nearest, distance_to_triangle(p, mesh, i));
  }
  return nearest;
}

/// Generalised winding number (Van Oosterom & Strackee 1983): 1 inside, 0 outside.
double winding_number(const Eigen::Vector3d& p, const TriangleMesh& mesh) {
  double solid_angle = 0;
  for (const auto& [i, j, k] : mesh.triangles) {
    const Eigen::Vector3d a = mesh.vertices[static_cast<std::size_t>(i)] - p;
    const Eigen::Vector3d b = mesh.vertices[static_cast<std::size_t>(j)] - p;
    const Eigen::Vector3d c = mesh.vertices[static_cast<std::size_t>(k)] - p;
    const double la = a.norm(), lb = b.norm(), lc = c.norm();
    solid_angle += 2 * std::atan2(a.dot(b.cross(c)),
                                  la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb);
  }
  return solid_angle / (4 * std::numbers::pi);
}

class MeshQueryOnShapes : public ::testing::TestWithParam<TriangleMesh> {};

TEST_P(MeshQueryOnShapes, ClosestPointMatchesBruteForce) {
  const TriangleMesh mesh = GetParam();
  const MeshQuery query(mesh);
  for (const auto& p : points_around(mesh, 1000)) {
    const ClosestPoint closest = query.closest_point(p);
    EXPECT_NEAR(closest.distance, brute_force_distance(p, mesh), 1e-12);
    EXPECT_NEAR((closest.point - p).norm(), closest.distance, 1e-12);
    EXPECT_NEAR(closest.normal.norm(), 1, 1e-12);
    const auto triangle = static_cast<std::size_t>(closest.triangle);
    EXPECT_LT(distance_to_triangle(closest.point, mesh, triangle), 1e-12);
  }
}

TEST_P(MeshQueryOnShapes, SignMatchesWindingNumberAndPseudonormal) {
  const TriangleMesh mesh = GetParam();
  const MeshQuery query(mesh);
  int inside = 0;
  for (const auto& p : points_around(mesh, 1000)) {
    const double distance = query.signed_distance(p);
    const bool expected = winding_number(p, mesh) > 0.5;
    inside += expected ? 1 : 0;
    EXPECT_EQ(distance < 0, expected) << p.transpose();
    const ClosestPoint closest = query.closest_point(p);
    if (closest.distance > 1e-9) {
      EXPECT_EQ((p - closest.point).dot(closest.normal) < 0, expected) << p.transpose();
    }
  }
  EXPECT_GT(inside, 20);
}

TEST_P(MeshQueryOnShapes, GuessDoesNotChangeTheDistance) {
  const TriangleMesh mesh = GetParam();
  const MeshQuery query(mesh);
  int guess = 0;
  for (const auto& p : points_around(mesh, 300)) {
    EXPECT_DOUBLE_EQ(query.closest_point(p, guess).distance, query.closest_point(p).distance);
    guess = (guess + 7) % static_cast<int>(mesh.triangles.size());
  }
}

TEST_P(MeshQueryOnShapes, RayEntersAtTheSurface) {
  const TriangleMesh mesh = GetParam();
  const MeshQuery query(mesh);
  int hits = 0;
  for (const auto& p : points_around(mesh, 500)) {
    const Eigen::Vector3d direction = (bounds(mesh).center() - p).normalized();
    const auto hit = query.raycast(p, 3 * direction, 10);
    if (!hit) continue;
    ++hits;
    const auto triangle = static_cast<std::size_t>(hit->triangle);
    const Eigen::Vector3d at = p + hit->distance * direction;
    EXPECT_LT(distance_to_triangle(at, mesh, triangle), 1e-12);
    const double before = 0.999 * hit->distance;
    EXPECT_FALSE(query.raycast(p, direction, before));
    EXPECT_EQ(query.inside(p), query.inside(p + before * direction));
  }
  EXPECT_GT(hits, 100);
}

INSTANTIATE_TEST_SUITE_P(Shapes, MeshQueryOnShapes,
                         ::testing::Values(box_mesh(0.05, 0.09, 0.17),
                                           torus_mesh(0.04, 0.015, 40, 18),
                                           torus_mesh(0.04, 0.015, 3, 60)));

TEST(MeshQuery, PseudonormalsOfABoxAreItsDiagonals) {
  const MeshQuery query(box_mesh(2, 2, 2));
  const auto normal = [&query](double x, double y, double z) -> Eigen::Vector3d {
    return query.closest_point({x, y, z}).normal;
  };
  EXPECT_LT((normal(0.3, 0.4, 3) - Eigen::Vector3d(0, 0, 1)).norm(), 1e-12);
  EXPECT_LT((normal(3, 0.4, 3) - Eigen::Vector3d(1, 0, 1).normalized()).norm(), 1e-12);
  EXPECT_LT((normal(-3, 3, 3) - Eigen::Vector3d(-1, 1, 1).normalized()).norm(), 1e-12);
}

TEST(MeshQuery, VerticesAtEqualPositionsShareAPseudonormal) {
  const TriangleMesh box = box_mesh(2, 2, 2);
  TriangleMesh soup;
  for (const auto& triangle : box.triangles) {
    const int n = static_cast<int>(soup.vertices.size());
    for (const int i : triangle) soup.vertices.push_back(box.vertices[static_cast<std::size_t>(i)]);
    soup.triangles.push_back({n, n + 1, n + 2});
  }
  const MeshQuery query(soup);
  const auto corner = query.closest_point({3, 3, 3}).normal;
  EXPECT_LT((corner - Eigen::Vector3d(1, 1, 1).normalized()).norm(), 1e-12);
}

TEST(MeshQuery, DegenerateTrianglesDoNotDisturb) {
  TriangleMesh mesh = box_mesh(2, 2, 2);
  mesh.triangles.push_back({0, 0, 0});
  mesh.triangles.push_back({0, 1, 1});
  const MeshQuery query(mesh);
  EXPECT_NEAR(query.closest_point({0, -1.5, -1.5}).distance, std::sqrt(0.5), 1e-12);
  EXPECT_NEAR(query.signed_distance({0.1, 0.2, -0.7}), -0.3, 1e-12);
}

TEST(MeshQuery, RayThroughSharedEdgesAndAlongFacesIsNotLost) {
  const MeshQuery query(box_mesh(2, 2, 2));
  const auto through_diagonal = query.raycast({0, 0, 5}, {0, 0, -1}, 10);
  ASSERT_TRUE(through_diagonal);
  EXPECT_NEAR(through_diagonal->distance, 4, 1e-12);
  const auto through_corner = query.raycast({5, 5, 5}, {-1, -1, -1}, 10);
  ASSERT_TRUE(through_corner);
  EXPECT_NEAR(through_corner->distance, std::sqrt(48), 1e-12);
  EXPECT_FALSE(query.raycast({0, 0, 5}, {0, 0, 1}, 10));
  EXPECT_FALSE(query.raycast({0, 0, 5}, {0, 0, -1}, 3.9));
}

TEST(MeshQuery, CavityIsOutside) {
  TriangleMesh cavity = box_mesh(1, 1, 1);
  for (auto& triangle : cavity.triangles) std::swap(triangle[1], triangle[2]);
  const MeshQuery query(joined(box_mesh(2, 2, 2), cavity));
  EXPECT_NEAR(query.signed_distance({0.05, 0.1, 0.2}), 0.3, 1e-12);
  EXPECT_NEAR(query.signed_distance({0.6, 0.05, 0.1}), -0.1, 1e-12);
}

TEST(MeshQuery, BadInputIsNamed) {
  EXPECT_THROW(MeshQuery(TriangleMesh{}), BadInput);
  TriangleMesh mesh = box_mesh(1, 1, 1);
  mesh.triangles[3][1] = 8;
  EXPECT_THROW(MeshQuery{mesh}, BadInput);
  mesh = box_mesh(1, 1, 1);
  mesh.vertices[2].x() = std::nan("");
  EXPECT_THROW(MeshQuery{mesh}, BadInput);
  const MeshQuery query(box_mesh(1, 1, 1));
  EXPECT_THROW(query.closest_point({std::nan(""), 0, 0}), BadInput);
}

TEST(Mesh, BoundsAreaAndMotion) {
  const TriangleMesh box = box_mesh(1, 2, 3);
  EXPECT_NEAR(area(box), 22, 1e-12);
  EXPECT_TRUE(bounds(box).sizes().isApprox(Eigen::Vector3d(1, 2, 3)));
  EXPECT_TRUE(bounds(TriangleMesh{}).isEmpty());
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.rotate(Eigen::AngleAxisd(std::numbers::pi / 2, Eigen::Vector3d::UnitZ()));
  T.pretranslate(Eigen::Vector3d(10, 0, 0));
  const TriangleMesh moved = transformed(T, box);
  EXPECT_NEAR(area(moved), 22, 1e-12);
  EXPECT_TRUE(bounds(moved).min().isApprox(Eigen::Vector3d(9, -0.5, -1.5)));
}

}  // namespace
}  // namespace palpate::geometry
