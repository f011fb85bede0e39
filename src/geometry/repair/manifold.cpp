// SPDX-License-Identifier: Apache-2.0
#include "geometry/repair/manifold.hpp"

#include <algorithm>
#include <cmath>

#include "geometry/mesh/mesh_topology.hpp"
#include "palpate/core/error.hpp"

namespace palpate::geometry {
namespace {

/// Over a two-faced edge: the other face, and whether it winds to the other side.
struct EdgeNeighbour {
  int triangle;
  bool opposed;
};

std::vector<std::vector<EdgeNeighbour>> neighbours_of(const TriangleMesh& mesh) {
  std::vector<std::vector<EdgeNeighbour>> neighbours(mesh.triangles.size());
  for_each_edge(edge_uses(mesh), [&neighbours](std::span<const EdgeUse> edge) {
    if (edge.size() != 2) return;
    const bool opposed = edge[0].forward == edge[1].forward;
    const int a = edge[0].triangle, b = edge[1].triangle;
    neighbours[static_cast<std::size_t>(a)].push_back({b, opposed});
    neighbours[static_cast<std::size_t>(b)].push_back({a, opposed});
  });
  return neighbours;
}

enum class Side : char { kUnknown, kSame, kOpposite };

/// The faces connected with `seed`, each marked with its side relative to that of the seed.
std::vector<int> mark_part(int seed, const std::vector<std::vector<EdgeNeighbour>>& neighbours,
                           std::vector<Side>& sides) {
  std::vector<int> part{seed};
  sides[static_cast<std::size_t>(seed)] = Side::kSame;
  for (std::size_t k = 0; k < part.size(); ++k) {
    const auto here = static_cast<std::size_t>(part[k]);
    for (const auto& [triangle, opposed] : neighbours[here]) {
      const bool same = (sides[here] == Side::kSame) != opposed;
      const Side expected = same ? Side::kSame : Side::kOpposite;
      Side& side = sides[static_cast<std::size_t>(triangle)];
      if (side == Side::kUnknown) {
        side = expected;
        part.push_back(triangle);
      } else if (side != expected) {
        throw BadInput("the mesh has a one-sided part, like a Moebius strip");
      }
    }
  }
  return part;
}

/// Angle of a face about its edge, from an arbitrary zero that depends on the edge alone.
double angle_about_edge(const TriangleMesh& mesh, const EdgeUse& use) {
  const auto vertex = [&mesh](int i) { return mesh.vertices[static_cast<std::size_t>(i)]; };
  const auto& triangle = mesh.triangles[static_cast<std::size_t>(use.triangle)];
  const Eigen::Vector3d axis = (vertex(use.high) - vertex(use.low)).normalized();
  const Eigen::Vector3d x = axis.unitOrthogonal(), y = axis.cross(x);
  const Eigen::Vector3d to =
      vertex(triangle[static_cast<std::size_t>((use.corner + 2) % 3)]) - vertex(use.low);
  return std::atan2(y.dot(to), x.dot(to));
}

/// Pairs of faces that stay together over an edge.
///
/// A face that runs along the edge has the outside at larger angles about it and the solid at
/// smaller ones; so a face that runs against it, followed by one that runs along it, bound a wedge
/// of the solid.
std::vector<std::pair<EdgeUse, EdgeUse>> pairs_over(std::span<const EdgeUse> edge,
                                                    const TriangleMesh& mesh) {
  if (edge.size() == 2) {
    if (edge[0].forward == edge[1].forward) return {};
    return {{edge[0], edge[1]}};
  }
  std::vector<std::pair<double, EdgeUse>> around;
  for (const EdgeUse& use : edge) around.emplace_back(angle_about_edge(mesh, use), use);
  std::stable_sort(around.begin(), around.end(),
                   [](const auto& a, const auto& b) { return a.first < b.first; });
  std::vector<std::pair<EdgeUse, EdgeUse>> pairs;
  for (std::size_t k = 0; k < around.size(); ++k) {
    const EdgeUse &use = around[k].second, &next = around[(k + 1) % around.size()].second;
    if (!use.forward && next.forward) pairs.emplace_back(use, next);
  }
  return pairs;
}

int corner_id(int triangle, int corner) { return 3 * triangle + corner % 3; }

}  // namespace

int make_winding_consistent(TriangleMesh& mesh) {
  const auto neighbours = neighbours_of(mesh);
  std::vector<Side> sides(mesh.triangles.size(), Side::kUnknown);
  int turned = 0;
  for (std::size_t i = 0; i < sides.size(); ++i) {
    if (sides[i] != Side::kUnknown) continue;
    const std::vector<int> part = mark_part(static_cast<int>(i), neighbours, sides);
    const auto is_opposite = [&sides](int triangle) {
      return sides[static_cast<std::size_t>(triangle)] == Side::kOpposite;
    };
    const auto opposite = std::count_if(part.begin(), part.end(), is_opposite);
    const bool turn_opposite = 2 * opposite <= std::ssize(part);
    for (const int triangle : part) {
      if (is_opposite(triangle) != turn_opposite) continue;
      auto& [a, b, c] = mesh.triangles[static_cast<std::size_t>(triangle)];
      std::swap(b, c);
      ++turned;
    }
  }
  return turned;
}

int separate_sheets(TriangleMesh& mesh) {
  DisjointSets sets(3 * mesh.triangles.size());
  for_each_edge(edge_uses(mesh), [&](std::span<const EdgeUse> edge) {
    for (const auto& [a, b] : pairs_over(edge, mesh)) {  // they run along the edge in turn
      sets.join(corner_id(a.triangle, a.corner), corner_id(b.triangle, b.corner + 1));
      sets.join(corner_id(a.triangle, a.corner + 1), corner_id(b.triangle, b.corner));
    }
  });
  const std::vector<int> labels = sets.labels();
  std::vector<char> in_use(mesh.vertices.size(), 0);
  std::vector<Eigen::Vector3d> vertices;
  for (std::size_t i = 0; i < labels.size(); ++i) {
    int& corner = mesh.triangles[i / 3][i % 3];
    in_use[static_cast<std::size_t>(corner)] = 1;
    if (labels[i] == static_cast<int>(vertices.size())) {
      vertices.push_back(mesh.vertices[static_cast<std::size_t>(corner)]);
    }
    corner = labels[i];
  }
  mesh.vertices = std::move(vertices);
  return static_cast<int>(mesh.vertices.size()) -
         static_cast<int>(std::count(in_use.begin(), in_use.end(), 1));
}

}  // namespace palpate::geometry
