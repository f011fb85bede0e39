// SPDX-License-Identifier: Apache-2.0
#include "geometry/mesh/adjacency.hpp"

#include "geometry/mesh/weld.hpp"

namespace palpate::geometry {

Adjacency::Adjacency(const TriangleMesh& mesh)
    : welded_(mesh.triangles), around_(mesh.vertices.size()) {
  const std::vector<int> first = first_at_same_position(mesh);
  for (std::size_t i = 0; i < welded_.size(); ++i) {
    for (int& vertex : welded_[i]) {
      vertex = first[static_cast<std::size_t>(vertex)];
      around_[static_cast<std::size_t>(vertex)].push_back(static_cast<int>(i));
    }
  }
}

}  // namespace palpate::geometry
