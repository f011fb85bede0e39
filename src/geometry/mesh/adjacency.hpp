// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <vector>

#include "geometry/mesh/triangle.hpp"

namespace palpate::geometry {

/// Which triangles share a triangle's edges and corners; vertices at equal positions count as one.
class Adjacency {
 public:
  explicit Adjacency(const TriangleMesh& mesh);

  /// Calls visit(triangle) for the others that share the feature; none share a face.
  template <typename Visit>
  void visit_sharing(int triangle, Feature feature, Visit visit) const {
    if (feature == Feature::kFace) return;
    const auto& own = welded_[static_cast<std::size_t>(triangle)];
    const auto k = static_cast<std::size_t>(feature) % 3;
    const bool edge = feature >= Feature::kEdge0;
    for (const int other : around_[static_cast<std::size_t>(own[k])]) {
      if (other != triangle && (!edge || touches(other, own[(k + 1) % 3]))) visit(other);
    }
  }

 private:
  bool touches(int triangle, int vertex) const {
    const auto& t = welded_[static_cast<std::size_t>(triangle)];
    return t[0] == vertex || t[1] == vertex || t[2] == vertex;
  }

  std::vector<std::array<int, 3>> welded_;  // triangles over vertices of distinct positions
  std::vector<std::vector<int>> around_;    // triangles at each vertex
};

}  // namespace palpate::geometry
