// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <vector>

#include "palpate/geometry/mesh/mesh.hpp"

namespace palpate::geometry {

/// @throws BadInput if a vertex is not finite, or a triangle names one that is not there
void check_mesh(const TriangleMesh& mesh);

/// Edge k of a triangle, from its corner k to the next one.
struct EdgeUse {
  int low, high;  // vertices
  int triangle, corner;
  bool forward;  // the triangle runs from low to high
};

/// All edges of all triangles, those between the same vertices in a row; edges from a vertex to
/// itself are left out.
std::vector<EdgeUse> edge_uses(const TriangleMesh& mesh);

/// Calls visit(span of EdgeUse) for each edge of the mesh.
template <typename Visit>
void for_each_edge(const std::vector<EdgeUse>& uses, Visit visit) {
  for (std::size_t begin = 0, end = 0; begin < uses.size(); begin = end) {
    while (end < uses.size() && uses[end].low == uses[begin].low &&
           uses[end].high == uses[begin].high) {
      ++end;
    }
    visit(std::span<const EdgeUse>(uses).subspan(begin, end - begin));
  }
}

/// Partition of 0..count-1 (Tarjan 1975).
class DisjointSets {
 public:
  explicit DisjointSets(std::size_t count);
  int root(int i);
  void join(int i, int j);

  /// For each member the number of its set, counted in the order of their first members.
  std::vector<int> labels();

 private:
  std::vector<int> parent_;
};

/// For each triangle the number of its component: triangles that are connected over edges.
std::vector<int> component_labels(const TriangleMesh& mesh);

/// Signed volume of the tetrahedra from the middle of the bounds to the triangles, m^3; of a closed
/// mesh the volume it encloses.
double signed_volume(const TriangleMesh& mesh);

}  // namespace palpate::geometry
