// SPDX-License-Identifier: Apache-2.0
#include "geometry/mesh/mesh_topology.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <numeric>
#include <tuple>

#include "geometry/mesh/triangle.hpp"
#include "palpate/core/error.hpp"

namespace palpate::geometry {

void check_mesh(const TriangleMesh& mesh) {
  const auto vertices = static_cast<int>(mesh.vertices.size());
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
    if (!mesh.vertices[i].allFinite()) {
      throw BadInput(fmt::format("vertex {} of the mesh is not finite", i));
    }
  }
  for (const auto& triangle : mesh.triangles) {
    for (const int i : triangle) {
      if (i >= 0 && i < vertices) continue;
      throw BadInput(fmt::format("triangle names vertex {}, but the mesh has {}", i, vertices));
    }
  }
}

std::vector<EdgeUse> edge_uses(const TriangleMesh& mesh) {
  std::vector<EdgeUse> uses;
  uses.reserve(3 * mesh.triangles.size());
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    for (int k = 0; k < 3; ++k) {
      const int from = mesh.triangles[i][static_cast<std::size_t>(k)];
      const int to = mesh.triangles[i][static_cast<std::size_t>((k + 1) % 3)];
      if (from == to) continue;
      uses.push_back({std::min(from, to), std::max(from, to), static_cast<int>(i), k, from < to});
    }
  }
  std::sort(uses.begin(), uses.end(), [](const EdgeUse& a, const EdgeUse& b) {
    return std::tie(a.low, a.high, a.triangle, a.corner) <
           std::tie(b.low, b.high, b.triangle, b.corner);
  });
  return uses;
}

DisjointSets::DisjointSets(std::size_t count) : parent_(count) {
  std::iota(parent_.begin(), parent_.end(), 0);
}

int DisjointSets::root(int i) {
  const auto parent = [this](int of) -> int& { return parent_[static_cast<std::size_t>(of)]; };
  while (parent(i) != i) {
    parent(i) = parent(parent(i));
    i = parent(i);
  }
  return i;
}

void DisjointSets::join(int i, int j) {
  const int a = root(i), b = root(j);
  parent_[static_cast<std::size_t>(std::max(a, b))] = std::min(a, b);
}

std::vector<int> DisjointSets::labels() {
  std::vector<int> labels(parent_.size());
  int next = 0;
  for (std::size_t i = 0; i < parent_.size(); ++i) {
    const int first = root(static_cast<int>(i));  // never after i: roots are the smallest members
    labels[i] = first == static_cast<int>(i) ? next++ : labels[static_cast<std::size_t>(first)];
  }
  return labels;
}

std::vector<int> component_labels(const TriangleMesh& mesh) {
  DisjointSets sets(mesh.triangles.size());
  for_each_edge(edge_uses(mesh), [&sets](std::span<const EdgeUse> edge) {
    for (const EdgeUse& use : edge) sets.join(edge[0].triangle, use.triangle);
  });
  return sets.labels();
}

double signed_volume(const TriangleMesh& mesh) {
  if (mesh.vertices.empty()) return 0;
  const Eigen::Vector3d apex = bounds(mesh).center();  // near the mesh, so that little cancels
  double volume = 0;
  for (const auto& triangle : mesh.triangles) {
    const Corners t = corners(mesh, triangle);
    volume += (t[0] - apex).dot((t[1] - apex).cross(t[2] - apex)) / 6;
  }
  return volume;
}

}  // namespace palpate::geometry
