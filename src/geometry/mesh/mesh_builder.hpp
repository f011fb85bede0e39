// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "palpate/geometry/mesh/mesh.hpp"

namespace palpate::geometry {

/// @throws BadInput "FILE: WHAT"
[[noreturn]] void bad_file(std::string_view file, std::string_view what);

/// Collects what a mesh file holds and checks it.
class MeshBuilder {
 public:
  explicit MeshBuilder(std::string_view file) : file_(file) {}

  std::size_t vertices() const { return mesh_.vertices.size(); }
  std::size_t faces() const { return face_ends_.size(); }

  /// @throws BadInput for a coordinate that is not finite
  void add_vertex(const Eigen::Vector3d& position);

  /// A polygon of vertices counted from 0, which may come later in the file.
  /// @throws BadInput unless it has 3..1000 corners
  void add_face(std::span<const std::int64_t> corners);

  /// The mesh with all polygons triangulated.
  /// @throws BadInput if there is no face, or one that names a vertex that is not there
  TriangleMesh finish() &&;

 private:
  void triangulate(std::size_t face, std::span<const std::int64_t> corners);

  std::string file_;
  TriangleMesh mesh_;
  std::vector<std::int64_t> corners_;
  std::vector<std::size_t> face_ends_;  // of each face's corners in corners_
};

}  // namespace palpate::geometry
