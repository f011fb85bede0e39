// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "geometry/mesh/triangle.hpp"
#include "palpate/geometry/mesh/mesh.hpp"

namespace palpate::geometry {

/// Outward unit normals of all faces, edges and vertices: an edge's is the mean of its faces', a
/// vertex's is weighted by their angles (Baerentzen & Aanaes 2005). Vertices at equal positions
/// count as one.
class Pseudonormals {
 public:
  explicit Pseudonormals(const TriangleMesh& mesh);

  Eigen::Vector3d at(int triangle, Feature feature) const {
    return normals_[static_cast<std::size_t>(triangle)][static_cast<std::size_t>(feature)];
  }

 private:
  std::vector<std::array<Eigen::Vector3d, 7>> normals_;  // [triangle][feature]
};

}  // namespace palpate::geometry
