// SPDX-License-Identifier: Apache-2.0
#include "palpate/geometry/repair/mesh_repair.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <limits>

#include "data.hpp"
#include "geometry/test_meshes.hpp"
#include "palpate/core/assets.hpp"
#include "palpate/core/error.hpp"
#include "palpate/core/random.hpp"
#include "palpate/geometry/io/mesh_io.hpp"
#include "palpate/geometry/objects/shapes.hpp"

namespace palpate::geometry {
namespace {

using testing::box_mesh;
using testing::joined;
using testing::torus_mesh;

TriangleMesh moved(const TriangleMesh& mesh, double x, double y, double z) {
  return transformed(Eigen::Isometry3d(Eigen::Translation3d(x, y, z)), mesh);
}

TriangleMesh inside_out(TriangleMesh mesh) {
  for (auto& triangle : mesh.triangles) std::swap(triangle[1], triangle[2]);
  return mesh;
}

/// Repairs, and checks that the result is sound and that one action mentions `action`.
TriangleMesh expect_repaired(const TriangleMesh& mesh, const std::string& action, double volume) {
  const RepairedMesh repaired = repair(mesh);
  const MeshReport report = inspect(repaired.mesh);
  EXPECT_TRUE(report.watertight);
  EXPECT_NEAR(report.volume, volume, 1e-9 * volume) << action;
  const auto mentions = [&action](const std::string& text) {
    return text.find(action) != std::string::npos;
  };
  EXPECT_TRUE(std::ranges::any_of(repaired.actions, mentions)) << action;
  EXPECT_TRUE(repair(repaired.mesh).actions.empty()) << "a second repair after " << action;
  return repaired.mesh;
}

TEST(Inspect, CountsEachDefect) {
  MeshReport report = inspect(torus_mesh(0.04, 0.01, 12, 8));
  EXPECT_EQ(report.vertices, 96);
  EXPECT_EQ(report.triangles, 192);
  EXPECT_EQ(report.components, 1);
  EXPECT_TRUE(report.watertight);

  TriangleMesh mesh = joined(box_mesh(1, 2, 3), box_mesh(1, 1, 1));
  report = inspect(mesh);
  EXPECT_EQ(report.components, 2);
  EXPECT_NEAR(report.volume, 7, 1e-12);

  mesh = box_mesh(1, 2, 3);
  std::swap(mesh.triangles[0][0], mesh.triangles[0][1]);
  EXPECT_EQ(inspect(mesh).flipped_edges, 3);
  mesh = box_mesh(1, 2, 3);
  mesh.triangles.pop_back();
  EXPECT_EQ(inspect(mesh).boundary_edges, 3);
  mesh.triangles.push_back(mesh.triangles[0]);
  mesh.triangles.push_back({0, 0, 5});
  report = inspect(mesh);
  EXPECT_EQ(report.duplicate_faces, 1);
  EXPECT_EQ(report.degenerate_faces, 1);
  EXPECT_EQ(report.non_manifold_edges, 3);
  EXPECT_FALSE(report.watertight);
  EXPECT_FALSE(inspect(TriangleMesh{}).watertight);
}

TEST(Repair, LeavesASoundMeshAsItIs) {
  for (const TriangleMesh& mesh : {box_mesh(1, 2, 3), torus_mesh(0.04, 0.01, 12, 8)}) {
    const RepairedMesh repaired = repair(mesh);
    EXPECT_TRUE(repaired.actions.empty());
    EXPECT_EQ(repaired.mesh.vertices, mesh.vertices);
    EXPECT_EQ(repaired.mesh.triangles, mesh.triangles);
  }
}

TEST(Repair, WeldsATriangleSoup) {
  const TriangleMesh box = box_mesh(1, 2, 3);
  TriangleMesh soup;
  for (const auto& triangle : box.triangles) {
    const int n = static_cast<int>(soup.vertices.size());
    for (const int i : triangle) soup.vertices.push_back(box.vertices[static_cast<std::size_t>(i)]);
    soup.triangles.push_back({n, n + 1, n + 2});
  }
  EXPECT_EQ(expect_repaired(soup, "28 duplicate or unused vertices", 6).vertices.size(), 8U);
}

TEST(Repair, LeavesOutUnusedVertices) {
  TriangleMesh mesh = box_mesh(1, 2, 3);
  mesh.vertices.insert(mesh.vertices.begin(), {9, 9, 9});
  for (auto& triangle : mesh.triangles) {
    for (int& i : triangle) ++i;
  }
  EXPECT_EQ(expect_repaired(mesh, "1 duplicate or unused vertex", 6).vertices.size(), 8U);
}

TEST(Repair, DropsDegenerateAndDuplicateFaces) {
  TriangleMesh mesh = box_mesh(1, 2, 3);
  mesh.triangles.push_back({0, 0, 1});
  EXPECT_EQ(expect_repaired(mesh, "1 degenerate face", 6).triangles.size(), 12U);
  mesh = box_mesh(1, 2, 3);
  const auto [a, b, c] = mesh.triangles[4];
  mesh.triangles.push_back({b, c, a});
  mesh.triangles.push_back({a, b, c});
  EXPECT_EQ(expect_repaired(mesh, "2 duplicate faces", 6).triangles.size(), 12U);
}

TEST(Repair, RemovesAWallWithinASolid) {
  TriangleMesh mesh = joined(box_mesh(1, 1, 1), moved(box_mesh(1, 1, 1), 0, 0, 1));
  for (auto& triangle : mesh.triangles) {  // the lower box's top corners are the upper's bottom
    for (int& i : triangle) i = i >= 8 && i < 12 ? i - 4 : i;
  }
  // Both boxes' sides of the wall, cut alike, so that its faces are duplicates that wind both ways.
  std::erase_if(mesh.triangles, [](const std::array<int, 3>& t) {
    return std::ranges::all_of(t, [](int i) { return i >= 4 && i < 8; });
  });
  for (const auto& [a, b, c] : {std::array{4, 5, 6}, std::array{5, 7, 6}}) {
    mesh.triangles.push_back({a, b, c});
    mesh.triangles.push_back({a, c, b});
  }
  EXPECT_EQ(inspect(mesh).non_manifold_edges, 5);
  EXPECT_EQ(expect_repaired(mesh, "4 duplicate faces", 2).triangles.size(), 20U);
}

TEST(Repair, MakesWindingConsistentAndOutward) {
  TriangleMesh mesh = torus_mesh(0.04, 0.01, 12, 8);
  const double volume = inspect(mesh).volume;
  for (std::size_t i = 0; i < mesh.triangles.size(); i += 3) {
    std::swap(mesh.triangles[i][0], mesh.triangles[i][1]);
  }
  expect_repaired(mesh, "turned 64 faces to wind like the others", volume);
  expect_repaired(inside_out(box_mesh(1, 2, 3)), "turned 12 faces outward", 6);
}

TEST(Repair, KeepsACavityButTurnsAPartBesideIt) {
  const TriangleMesh cavity = inside_out(box_mesh(1, 1, 1));
  EXPECT_TRUE(repair(joined(box_mesh(2, 2, 2), cavity)).actions.empty());
  expect_repaired(joined(box_mesh(2, 2, 2), moved(cavity, 5, 0, 0)), "turned 12 faces outward", 9);
}

TEST(Repair, SeparatesSheetsAtAnEdgeAndAtAVertex) {
  TriangleMesh edge = joined(box_mesh(1, 1, 1), moved(box_mesh(1, 1, 1), 1, 1, 0));
  for (auto& triangle : edge.triangles) {
    for (int& i : triangle) i = i == 8 ? 3 : i == 12 ? 7 : i;
  }
  EXPECT_EQ(inspect(edge).non_manifold_edges, 1);
  EXPECT_EQ(inspect(expect_repaired(edge, "1 non-manifold edge", 2)).components, 2);

  TriangleMesh vertex = joined(box_mesh(1, 1, 1), moved(box_mesh(1, 1, 1), 1, 1, 1));
  for (auto& triangle : vertex.triangles) {
    for (int& i : triangle) i = i == 8 ? 7 : i;
  }
  EXPECT_EQ(expect_repaired(vertex, "with 1 more vertex", 2).vertices.size(), 16U);
}

TEST(Repair, DropsAFinOnAnEdge) {
  TriangleMesh mesh = box_mesh(1, 2, 3);
  mesh.vertices.emplace_back(3, 3, 3);
  mesh.triangles.push_back({5, 7, 8});
  EXPECT_EQ(expect_repaired(mesh, "dropped 1 tiny or flat part", 6).triangles.size(), 12U);
}

TEST(Repair, FillsHoles) {
  TriangleMesh mesh = box_mesh(1, 2, 3);
  mesh.triangles.erase(mesh.triangles.begin() + 2, mesh.triangles.begin() + 4);
  EXPECT_EQ(expect_repaired(mesh, "filled 1 hole with 2 triangles", 6).triangles.size(), 12U);

  // A whole end of a tube: every patch over a flat rim encloses the same volume.
  TriangleMesh tube;
  const int n = 30;
  double polygon = 0;
  for (int i = 0; i < n; ++i) {
    const double u = 2 * std::numbers::pi * i / n, radius = i % 2 ? 1 : 0.6;
    tube.vertices.emplace_back(radius * std::cos(u), radius * std::sin(u), 0);
    tube.vertices.emplace_back(radius * std::cos(u), radius * std::sin(u), 2);
    const int a = 2 * i, b = 2 * ((i + 1) % n);
    tube.triangles.push_back({a, b, a + 1});
    tube.triangles.push_back({b, b + 1, a + 1});
    polygon += 0.5 * 0.6 * std::sin(2 * std::numbers::pi / n);
  }
  expect_repaired(tube, "filled 2 holes with 56 triangles", 2 * polygon);
}

TEST(Repair, DropsSpecks) {
  const TriangleMesh speck = moved(box_mesh(0.01, 0.01, 0.01), 0, 0, 4);
  const TriangleMesh mesh = joined(box_mesh(1, 2, 3), speck);
  EXPECT_EQ(expect_repaired(mesh, "dropped 1 tiny or flat part of 12 faces", 6).vertices.size(),
            8U);
}

TEST(Repair, RefusesWhatBoundsNothing) {
  EXPECT_THROW(repair(TriangleMesh{}), BadInput);
  TriangleMesh sheet;
  sheet.vertices = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
  sheet.triangles = {{0, 1, 2}, {0, 2, 3}};
  EXPECT_THROW(repair(sheet), BadInput);
  TriangleMesh moebius;
  const int n = 9;
  for (int i = 0; i < n; ++i) {
    const double u = 2 * std::numbers::pi * i / n;
    for (const double w : {-0.3, 0.3}) {
      const double radius = 1 + w * std::cos(u / 2);
      moebius.vertices.emplace_back(radius * std::cos(u), radius * std::sin(u),
                                    w * std::sin(u / 2));
    }
    const int a = 2 * i, b = (2 * i + 2) % (2 * n), twist = i == n - 1 ? 1 : 0;
    moebius.triangles.push_back({a, b + twist, a + 1});
    moebius.triangles.push_back({a + 1, b + twist, b + 1 - twist});
  }
  EXPECT_THROW(repair(moebius), BadInput);
  TriangleMesh mesh = box_mesh(1, 1, 1);
  mesh.triangles[0][0] = -1;
  EXPECT_THROW(repair(mesh), BadInput);
}

/// Random damage to a closed mesh: the result is watertight or the mesh is refused.
TEST(Repair, RandomDamageNeverYieldsAnUnsoundMesh) {
  const TriangleMesh sound = torus_mesh(0.04, 0.015, 20, 12);
  int repaired = 0;
  for (std::uint64_t seed = 0; seed < 60; ++seed) {
    RandomStream random(seed, "damage");
    TriangleMesh mesh = sound;
    for (int k = 0; k < 12; ++k) {
      auto& triangle = mesh.triangles[random.index(mesh.triangles.size())];
      switch (random.index(4)) {
        case 0:
          std::swap(triangle[0], triangle[1]);
          break;
        case 1:
          mesh.triangles.push_back(std::array(triangle));
          break;
        case 2:
          triangle[random.index(3)] = static_cast<int>(random.index(mesh.vertices.size()));
          break;
        default:
          mesh.triangles.erase(mesh.triangles.begin() +
                               static_cast<std::ptrdiff_t>(random.index(mesh.triangles.size())));
      }
    }
    try {
      const RepairedMesh result = repair(mesh);
      ++repaired;
      EXPECT_TRUE(inspect(result.mesh).watertight);
      EXPECT_NEAR(inspect(result.mesh).volume, inspect(sound).volume, 0.5 * inspect(sound).volume);
      EXPECT_EQ(repair(mesh).mesh.triangles, result.mesh.triangles) << "not deterministic";
    } catch (const BadInput&) {
    }
  }
  EXPECT_GT(repaired, 40);
}

TEST(Repair, InstalledBunnyIsMadeWatertight) {
  const RepairedMesh repaired = repair(load_mesh(asset("bunny.ply")));
  const MeshReport report = inspect(repaired.mesh);
  EXPECT_TRUE(report.watertight);
  EXPECT_EQ(report.components, 1);
  EXPECT_GT(report.volume, 0);
}

TriangleMesh rough(TriangleMesh mesh, double roughness) {
  RandomStream random(8);
  for (auto& vertex : mesh.vertices) vertex += roughness * random.unit_vector();
  return mesh;
}

/// As a scanner leaves it: rough, and without the base on which it stood.
TriangleMesh scan_of(TriangleMesh mesh, double roughness) {
  double lowest = std::numeric_limits<double>::infinity();
  for (const auto& vertex : mesh.vertices) lowest = std::min(lowest, vertex.z());
  std::erase_if(mesh.triangles, [&](const auto& triangle) {
    return std::all_of(triangle.begin(), triangle.end(), [&](int vertex) {
      return mesh.vertices[static_cast<std::size_t>(vertex)].z() < lowest + 0.002;
    });
  });
  return rough(std::move(mesh), roughness);
}

void expect_closed_scan(const TriangleMesh& scan, double volume) {
  EXPECT_FALSE(inspect(scan).watertight);
  const RepairedMesh closed = repair(scan);
  EXPECT_TRUE(inspect(closed.mesh).watertight);
  EXPECT_EQ(inspect(closed.mesh).components, 1);
  EXPECT_NEAR(inspect(closed.mesh).volume, volume, 0.04 * volume);
  EXPECT_TRUE(repair(closed.mesh).actions.empty());
}

TEST(Repair, ScansWithoutTheirBaseAreClosed) {
  const TriangleMesh duck = duck_mesh();
  expect_closed_scan(scan_of(duck, 1e-4), inspect(duck).volume);
  // Of the full scan with its base closed.
  if (const auto bunny = real_data("bunny_res3.ply")) expect_closed_scan(load_mesh(*bunny), 7.5e-4);
}

TEST(Repair, WatertightScansAreLeftAlone) {
  std::vector<TriangleMesh> scans{rough(duck_mesh(), 1e-4), rough(mug_mesh(), 1e-4)};
  for (const char* name : {"ycb/025_mug.ply", "ycb/006_mustard_bottle.ply"}) {
    if (const auto file = real_data(name)) scans.push_back(load_mesh(*file));
  }
  for (std::size_t i = 0; i < scans.size(); ++i) {
    EXPECT_TRUE(repair(scans[i]).actions.empty()) << "scan " << i;
  }
}

}  // namespace
}  // namespace palpate::geometry
