// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

#include "palpate/geometry/cloud/point_cloud.hpp"

namespace palpate::geometry {

/// Reads a cloud: PLY, PCD (ascii, binary, binary_compressed), XYZ (lines of x y z [nx ny nz],
/// blanks or commas between, comments after #) or OBJ; normals are taken where every point has one,
/// in an XYZ only if they are unit vectors within 10 %.
/// A mesh (PLY or OBJ with faces, STL) is sampled uniformly over its area, with its faces' normals.
/// @param samples  of a mesh
/// @throws BadInput, naming the file and line, as load_mesh()
PointCloud load_cloud(const std::filesystem::path& path, std::size_t samples = 20000);

/// Writes a binary PLY with coordinates (and normals) in full precision, atomically.
void save_cloud(const std::filesystem::path& path, const PointCloud& cloud);

}  // namespace palpate::geometry
