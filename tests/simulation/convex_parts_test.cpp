// SPDX-License-Identifier: Apache-2.0
#include "palpate/simulation/world/convex_parts.hpp"

#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <string>

#include "palpate/core/error.hpp"
#include "simulation/scenes.hpp"

namespace palpate::simulation {
namespace {

/// An L of two arms; its inner corner comes first.
geometry::TriangleMesh bracket() {
  return prism({{0.02, 0.02}, {0.02, 0.08}, {0, 0.08}, {0, 0}, {0.12, 0}, {0.12, 0.02}}, 0.04);
}

double volume(const geometry::TriangleMesh& mesh) {
  double sum = 0;
  for (const auto& t : mesh.triangles) {
    const auto corner = [&](std::size_t k) {
      return mesh.vertices[static_cast<std::size_t>(t[k])];
    };
    sum += corner(0).dot(corner(1).cross(corner(2))) / 6;
  }
  return sum;
}

/// How far any vertex lies outside any of the part's faces, m.
double concavity(const geometry::TriangleMesh& part) {
  double worst = 0;
  for (const auto& t : part.triangles) {
    const auto corner = [&](std::size_t k) {
      return part.vertices[static_cast<std::size_t>(t[k])];
    };
    const Eigen::Vector3d n = (corner(1) - corner(0)).cross(corner(2) - corner(0)).normalized();
    for (const Eigen::Vector3d& v : part.vertices) worst = std::max(worst, n.dot(v - corner(0)));
  }
  return worst;
}

TEST(ConvexParts, AConvexBodyIsItsOnlyPart) {
  const auto parts = convex_parts(cuboid_mesh({0.05, 0.094, 0.175}));
  ASSERT_EQ(parts.size(), 1u);
  EXPECT_NEAR(volume(parts[0]), 0.05 * 0.094 * 0.175, 1e-8);
}

TEST(ConvexParts, ABracketFallsIntoConvexArms) {
  const auto parts = convex_parts(bracket());
  EXPECT_GE(parts.size(), 2u);
  double sum = 0;
  for (const auto& part : parts) {
    EXPECT_LT(concavity(part), 1e-6);
    EXPECT_LE(part.vertices.size(), 256u);
    sum += volume(part);
  }
  EXPECT_NEAR(sum, volume(bracket()), 0.1 * volume(bracket()));
}

/// A cache of its own for as long as it lives.
class OwnCache {
 public:
  explicit OwnCache(const std::string& name) : folder_(testing::TempDir() + name) {
    std::filesystem::remove_all(folder_);
    setenv("PALPATE_CACHE", folder_.c_str(), 1);
  }
  ~OwnCache() {
    unsetenv("PALPATE_CACHE");
    std::filesystem::remove_all(folder_);
  }
  bool is_empty() const {
    return !std::filesystem::exists(folder_) || std::filesystem::is_empty(folder_);
  }

 private:
  std::filesystem::path folder_;
};

void expect_same(const std::vector<geometry::TriangleMesh>& a,
                 const std::vector<geometry::TriangleMesh>& b) {
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t i = 0; i < a.size(); ++i) {
    EXPECT_EQ(a[i].vertices, b[i].vertices);
    EXPECT_EQ(a[i].triangles, b[i].triangles);
  }
}

TEST(ConvexParts, TheSameMeshGivesTheSameParts) {
  std::vector<geometry::TriangleMesh> first, second;
  {
    const OwnCache cache("convex_parts_first");
    first = convex_parts(bracket());
  }
  {
    const OwnCache cache("convex_parts_second");
    second = convex_parts(bracket());
  }
  expect_same(first, second);
}

TEST(ConvexParts, AreKeptInTheCache) {
  const OwnCache cache("convex_parts_kept");
  EXPECT_TRUE(cache.is_empty());
  const auto computed = convex_parts(bracket());
  EXPECT_FALSE(cache.is_empty());
  expect_same(computed, convex_parts(bracket()));
}

/// Cuboids of 10 mm that overlap in a row, as one mesh.
geometry::TriangleMesh row_of_cuboids(int count) {
  geometry::TriangleMesh row;
  for (int i = 0; i < count; ++i) {
    const int first = static_cast<int>(row.vertices.size());
    const geometry::TriangleMesh cuboid = cuboid_mesh({0.01, 0.01, 0.01});
    for (const auto& v : cuboid.vertices) {
      row.vertices.emplace_back(v + Eigen::Vector3d(0.004 * i, 0, 0));
    }
    for (const auto& [a, b, c] : cuboid.triangles) {
      row.triangles.push_back({a + first, b + first, c + first});
    }
  }
  return row;
}

TEST(ConvexParts, BodiesThatOverlapAreDecomposedOneByOne) {
  const OwnCache cache("convex_parts_bodies");
  const auto parts = convex_parts(row_of_cuboids(5));
  ASSERT_EQ(parts.size(), 5u);
  for (const auto& part : parts) EXPECT_NEAR(volume(part), 1e-6, 1e-9);
}

TEST(ConvexParts, AClosedCavityIsFilled) {
  const OwnCache cache("convex_parts_cavity");
  geometry::TriangleMesh hollow = row_of_cuboids(2);
  for (std::size_t i = 0; i < 8; ++i) hollow.vertices[8 + i] = 0.5 * hollow.vertices[i];
  for (std::size_t i = 12; i < 24; ++i) {
    std::swap(hollow.triangles[i][1], hollow.triangles[i][2]);
  }
  const auto parts = convex_parts(hollow);
  ASSERT_EQ(parts.size(), 1u);
  EXPECT_NEAR(volume(parts[0]), 1e-6, 1e-9);
}

TEST(ConvexParts, TooManyBodiesAreCounted) {
  try {
    convex_parts(row_of_cuboids(201));
    FAIL() << "201 bodies were accepted";
  } catch (const BadInput& error) {
    EXPECT_NE(std::string(error.what()).find("201 separate bodies"), std::string::npos);
  }
}

TEST(ConvexParts, NothingHasNoParts) {
  EXPECT_THROW(convex_parts(geometry::TriangleMesh{}), BadInput);
}

}  // namespace
}  // namespace palpate::simulation
