// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "palpate/geometry/mesh/mesh.hpp"

namespace palpate::geometry {

/// What a mesh is like, by its indices: vertices at equal positions count as different.
struct MeshReport {
  int vertices = 0;
  int triangles = 0;
  int components = 0;          ///< sets of faces connected over edges
  int boundary_edges = 0;      ///< of one face
  int non_manifold_edges = 0;  ///< of more than two faces
  int flipped_edges = 0;       ///< of two faces that wind to opposite sides
  int duplicate_faces = 0;     ///< of the vertices of an earlier face
  int degenerate_faces = 0;    ///< without area
  bool watertight = false;     ///< no boundary, non-manifold or flipped edges
  double volume = 0;           ///< m^3, negative if inside out; has no meaning unless watertight
};

/// @throws BadInput if a triangle names a vertex that is not there or not finite
MeshReport inspect(const TriangleMesh& mesh);

/// The mesh split into sets of faces connected over edges, each with the vertices it uses.
std::vector<TriangleMesh> components(const TriangleMesh& mesh);

struct RepairedMesh {
  TriangleMesh mesh;                 ///< watertight, of positive volume
  std::vector<std::string> actions;  ///< what was done, in words with numbers; empty if nothing
};

/// Makes the boundary of a solid of a mesh that nearly is one.
///
/// Welds vertices at equal positions, drops faces without area and duplicates, makes the winding
/// consistent, separates sheets that meet in an edge or a vertex, fills holes, drops fragments that
/// are flat or tiny, and turns what is left outward. Parts that wind inward within another part
/// remain: they bound a cavity.
/// @throws BadInput, saying why, if the result is not watertight or encloses no volume
RepairedMesh repair(const TriangleMesh& mesh);

}  // namespace palpate::geometry
