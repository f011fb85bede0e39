// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

#include "palpate/geometry/mesh/mesh.hpp"

namespace palpate::geometry {

/// Reads PLY (ascii, binary of either byte order), STL (ascii, binary) or OBJ, distinguished by
/// content and extension, in the file's own units. Polygons are triangulated, an STL's equal
/// vertices welded, and its solids read as one mesh; properties other than positions and faces are
/// skipped.
///
/// @throws BadInput, naming the file and the offending line or element: a file that is missing,
///         empty, truncated or of unknown format, a coordinate that is not finite, a face that
///         names a vertex the file lacks, a count that the file's size cannot hold
TriangleMesh load_mesh(const std::filesystem::path& path);

/// Writes a binary PLY with coordinates in full precision, atomically.
void save_ply(const std::filesystem::path& path, const TriangleMesh& mesh);

}  // namespace palpate::geometry
