// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include "palpate/geometry/mesh/mesh.hpp"

namespace palpate::geometry {

/// Each reads the content of a file of its format; `file` is for messages.
/// @throws BadInput as load_mesh does
TriangleMesh read_ply(std::string_view content, std::string_view file);
TriangleMesh read_stl(std::string_view content, std::string_view file);
TriangleMesh read_obj(std::string_view content, std::string_view file);

/// The extension with its dot, A to Z made lower case.
std::string lower_case_extension(const std::filesystem::path& path);

/// Whether the content is a binary STL: its size fits its own count of triangles.
bool is_binary_stl(std::string_view content);

}  // namespace palpate::geometry
