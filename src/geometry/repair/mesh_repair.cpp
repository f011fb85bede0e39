// SPDX-License-Identifier: Apache-2.0
#include "palpate/geometry/repair/mesh_repair.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>

#include "geometry/mesh/mesh_topology.hpp"
#include "geometry/mesh/weld.hpp"
#include "geometry/repair/holes.hpp"
#include "geometry/repair/manifold.hpp"
#include "palpate/core/error.hpp"
#include "palpate/geometry/query/mesh_query.hpp"

namespace palpate::geometry {
namespace {

constexpr double kSpeckSize = 0.02;   // of the mesh's diagonal
constexpr double kFlatVolume = 1e-5;  // of area^1.5; a ball has 0.094

using Actions = std::vector<std::string>;

std::string counted(std::ptrdiff_t count, std::string_view one, std::string_view many) {
  return fmt::format("{} {}", count, count == 1 ? one : many);
}

/// The vertices of a closed mesh at equal positions are there on purpose, where sheets touch.
void weld(TriangleMesh& mesh, Actions& actions) {
  std::vector<int> target(mesh.vertices.size());
  std::iota(target.begin(), target.end(), 0);
  if (inspect(mesh).boundary_edges > 0) target = first_at_same_position(mesh);
  TriangleMesh result = merged(mesh, target);
  const auto fewer = std::ssize(mesh.vertices) - std::ssize(result.vertices);
  if (fewer == 0) return;
  mesh = std::move(result);
  actions.push_back("welded or left out " +
                    counted(fewer, "duplicate or unused vertex", "duplicate or unused vertices"));
}

void drop_faces_without_area(TriangleMesh& mesh, Actions& actions) {
  // Faces whose corners lie in a line are kept: they close the gap between their neighbours.
  const auto count = std::erase_if(mesh.triangles, [](const std::array<int, 3>& t) {
    return t[0] == t[1] || t[1] == t[2] || t[2] == t[0];
  });
  if (count > 0) {
    actions.push_back("dropped " + counted(static_cast<std::ptrdiff_t>(count), "degenerate face",
                                           "degenerate faces"));
  }
}

/// The vertices of a face in ascending order, and whether its winding is that order's.
std::pair<std::array<int, 3>, bool> sorted_with_sign(std::array<int, 3> t) {
  const bool even = (t[0] < t[1]) == ((t[1] < t[2]) == (t[0] < t[2]));
  std::sort(t.begin(), t.end());
  return {t, even};
}

/// Of faces on the same vertices one is left, or none if as many wind each way: they part a solid
/// from a solid.
void drop_duplicate_faces(TriangleMesh& mesh, Actions& actions) {
  std::map<std::array<int, 3>, int> surplus;
  for (const auto& triangle : mesh.triangles) {
    const auto [key, even] = sorted_with_sign(triangle);
    surplus[key] += even ? 1 : -1;
  }
  const auto count = std::erase_if(mesh.triangles, [&surplus](const std::array<int, 3>& triangle) {
    const auto [key, even] = sorted_with_sign(triangle);
    int& left = surplus.at(key);
    const bool keep = even ? left > 0 : left < 0;
    if (keep) left = 0;
    return !keep;
  });
  if (count > 0) {
    actions.push_back("dropped " + counted(static_cast<std::ptrdiff_t>(count), "duplicate face",
                                           "duplicate faces"));
  }
}

void fix_topology(TriangleMesh& mesh, Actions& actions) {
  const int turned = make_winding_consistent(mesh);
  if (turned > 0) {
    actions.push_back("turned " + counted(turned, "face", "faces") + " to wind like the others");
  }
  const int edges = inspect(mesh).non_manifold_edges;
  const int added = separate_sheets(mesh);
  if (edges + added > 0) {
    actions.push_back(fmt::format("separated sheets at {}, with {}",
                                  counted(edges, "non-manifold edge", "non-manifold edges"),
                                  counted(added, "more vertex", "more vertices")));
  }
  const FilledHoles filled = fill_holes(mesh);
  if (filled.count > 0) {
    actions.push_back(fmt::format("filled {} with {} (the largest {:.3g} wide, at most {} edges)",
                                  counted(filled.count, "hole", "holes"),
                                  counted(filled.triangles, "triangle", "triangles"),
                                  filled.largest, filled.max_edges));
  }
}

bool is_fragment(const TriangleMesh& part, double whole_diagonal) {
  if (bounds(part).diagonal().norm() < kSpeckSize * whole_diagonal) return true;
  return std::abs(signed_volume(part)) <= kFlatVolume * std::pow(area(part), 1.5);
}

void drop_fragments(const TriangleMesh& whole, std::vector<TriangleMesh>& parts, Actions& actions) {
  const double diagonal = bounds(whole).diagonal().norm();
  std::ptrdiff_t faces = 0;
  const auto count = std::erase_if(parts, [&](const TriangleMesh& part) {
    const bool drop = is_fragment(part, diagonal);
    if (drop) faces += std::ssize(part.triangles);
    return drop;
  });
  if (count > 0) {
    actions.push_back(fmt::format(
        "dropped {} of {}",
        counted(static_cast<std::ptrdiff_t>(count), "tiny or flat part", "tiny or flat parts"),
        counted(faces, "face", "faces")));
  }
}

bool lies_within(const TriangleMesh& part, const TriangleMesh& other) {
  const Eigen::AlignedBox3d box = bounds(other);
  if (!box.contains(bounds(part))) return false;
  const MeshQuery query(other);
  return std::all_of(part.vertices.begin(), part.vertices.end(),
                     [&query](const Eigen::Vector3d& vertex) { return query.inside(vertex); });
}

/// Parts that wind inward are turned, but for those within another one.
void turn_outward(std::vector<TriangleMesh>& parts, Actions& actions) {
  std::ptrdiff_t faces = 0;
  for (TriangleMesh& part : parts) {
    const auto holds_part = [&part](const TriangleMesh& other) {
      return &other != &part && lies_within(part, other);
    };
    if (signed_volume(part) >= 0 || std::any_of(parts.begin(), parts.end(), holds_part)) continue;
    for (auto& triangle : part.triangles) std::swap(triangle[1], triangle[2]);
    faces += std::ssize(part.triangles);
  }
  if (faces > 0) actions.push_back("turned " + counted(faces, "face", "faces") + " outward");
}

TriangleMesh joined(const std::vector<TriangleMesh>& parts) {
  TriangleMesh mesh;
  for (const TriangleMesh& part : parts) {
    const int offset = static_cast<int>(mesh.vertices.size());
    mesh.vertices.insert(mesh.vertices.end(), part.vertices.begin(), part.vertices.end());
    for (const auto& [a, b, c] : part.triangles) {
      mesh.triangles.push_back({a + offset, b + offset, c + offset});
    }
  }
  return mesh;
}

void expect_solid(const TriangleMesh& mesh) {
  if (mesh.triangles.empty()) throw BadInput("nothing of the mesh encloses a volume");
  const MeshReport report = inspect(mesh);
  if (!report.watertight) {
    throw BadInput(fmt::format(
        "the mesh cannot be made watertight: {} boundary, {} non-manifold and {} flipped edges "
        "remain",
        report.boundary_edges, report.non_manifold_edges, report.flipped_edges));
  }
  if (!(report.volume > 0)) {
    throw BadInput(fmt::format("the mesh encloses a volume of {:.3g}", report.volume));
  }
}

}  // namespace

RepairedMesh repair(const TriangleMesh& mesh) {
  RepairedMesh result{mesh, {}};
  weld(result.mesh, result.actions);
  drop_faces_without_area(result.mesh, result.actions);
  drop_duplicate_faces(result.mesh, result.actions);
  fix_topology(result.mesh, result.actions);
  std::vector<TriangleMesh> parts = components(result.mesh);
  drop_fragments(result.mesh, parts, result.actions);
  turn_outward(parts, result.actions);
  result.mesh = joined(parts);
  if (result.actions.empty()) result.mesh = mesh;  // its vertices in their own order
  expect_solid(result.mesh);
  return result;
}

}  // namespace palpate::geometry
