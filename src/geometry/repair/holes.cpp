// SPDX-License-Identifier: Apache-2.0
#include "geometry/repair/holes.hpp"

#include <algorithm>
#include <map>
#include <set>

#include "geometry/mesh/mesh_topology.hpp"
#include "geometry/mesh/polygon.hpp"

namespace palpate::geometry {
namespace {

using Loop = std::vector<int>;
using Edges = std::set<std::pair<int, int>>;  // low, high

/// Boundary edges in the order in which a patch runs along them: against the faces they have.
std::vector<Loop> boundary_loops(const TriangleMesh& mesh) {
  std::multimap<int, int> next;
  for_each_edge(edge_uses(mesh), [&next](std::span<const EdgeUse> edge) {
    if (edge.size() != 1) return;
    const auto [low, high] = std::pair(edge[0].low, edge[0].high);
    next.emplace(edge[0].forward ? high : low, edge[0].forward ? low : high);
  });
  std::vector<Loop> loops;
  while (!next.empty()) {
    Loop loop;
    int at = next.begin()->first;
    for (auto edge = next.begin(); edge != next.end(); edge = next.find(at)) {
      loop.push_back(at);
      at = edge->second;
      next.erase(edge);
      if (at == loop.front()) break;
    }
    if (at == loop.front()) loops.push_back(std::move(loop));
  }
  return loops;
}

bool visits_a_vertex_twice(Loop loop) {
  std::sort(loop.begin(), loop.end());
  return std::adjacent_find(loop.begin(), loop.end()) != loop.end();
}

std::vector<std::array<int, 3>> fan_around_centre(TriangleMesh& mesh, const Loop& loop) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const int i : loop) sum += mesh.vertices[static_cast<std::size_t>(i)];
  const int centre = static_cast<int>(mesh.vertices.size());
  mesh.vertices.emplace_back(sum / static_cast<double>(loop.size()));
  std::vector<std::array<int, 3>> triangles;
  for (std::size_t k = 0; k < loop.size(); ++k) {
    triangles.push_back({loop[k], loop[(k + 1) % loop.size()], centre});
  }
  return triangles;
}

void add_edges(Edges& edges, const std::vector<std::array<int, 3>>& triangles) {
  for (const auto& triangle : triangles) {
    for (std::size_t k = 0; k < 3; ++k) {
      edges.insert(std::minmax(triangle[k], triangle[(k + 1) % 3]));
    }
  }
}

double diagonal(const TriangleMesh& mesh, const Loop& loop) {
  Eigen::AlignedBox3d box;
  for (const int i : loop) box.extend(mesh.vertices[static_cast<std::size_t>(i)]);
  return box.diagonal().norm();
}

}  // namespace

FilledHoles fill_holes(TriangleMesh& mesh) {
  FilledHoles filled;
  const std::vector<Loop> loops = boundary_loops(mesh);
  Edges edges;
  if (!loops.empty()) add_edges(edges, mesh.triangles);
  for (const Loop& loop : loops) {
    if (loop.size() < 3 || loop.size() > kMaxCorners || visits_a_vertex_twice(loop)) continue;
    filled.largest = std::max(filled.largest, diagonal(mesh, loop));
    auto patch = clip_ears(mesh.vertices, loop,
                           [&edges](int a, int b) { return !edges.contains(std::minmax(a, b)); });
    if (!patch) patch = fan_around_centre(mesh, loop);
    mesh.triangles.insert(mesh.triangles.end(), patch->begin(), patch->end());
    add_edges(edges, *patch);
    ++filled.count;
    filled.triangles += static_cast<int>(patch->size());
    filled.max_edges = std::max(filled.max_edges, static_cast<int>(loop.size()));
  }
  return filled;
}

}  // namespace palpate::geometry
