// SPDX-License-Identifier: Apache-2.0
#include "palpate/geometry/io/mesh_io.hpp"

#include <fmt/format.h>

#include "geometry/io/byte_order.hpp"
#include "geometry/io/mesh_readers.hpp"
#include "geometry/mesh/mesh_builder.hpp"
#include "palpate/core/file.hpp"

namespace palpate::geometry {
namespace {

constexpr std::size_t kMaxBytes = std::size_t{1} << 30;  // so that an int counts all vertices

}  // namespace

std::string lower_case_extension(const std::filesystem::path& path) {
  std::string extension = path.extension().string();
  for (char& c : extension) c = c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  return extension;
}

TriangleMesh load_mesh(const std::filesystem::path& path) {
  const std::string content = read_file(path), file = path.string();
  if (content.empty()) bad_file(file, "empty file");
  if (content.size() > kMaxBytes) {
    bad_file(file, fmt::format("{} bytes, more than {}", content.size(), kMaxBytes));
  }
  const std::string extension = lower_case_extension(path);
  if (content.starts_with("ply\n") || content.starts_with("ply\r")) return read_ply(content, file);
  if (extension == ".ply") bad_file(file, "does not begin with 'ply', as a PLY file does");
  if (extension == ".obj") return read_obj(content, file);
  if (extension == ".stl" || content.starts_with("solid") || is_binary_stl(content)) {
    return read_stl(content, file);
  }
  bad_file(file, fmt::format("unknown format '{}': expected PLY, STL or OBJ", extension));
}

void save_ply(const std::filesystem::path& path, const TriangleMesh& mesh) {
  std::string bytes = fmt::format(
      "ply\nformat binary_little_endian 1.0\nelement vertex {}\nproperty double x\n"
      "property double y\nproperty double z\nelement face {}\n"
      "property list uchar int vertex_indices\nend_header\n",
      mesh.vertices.size(), mesh.triangles.size());
  for (const auto& vertex : mesh.vertices) {
    for (const double coordinate : vertex) append_value(bytes, coordinate);
  }
  for (const auto& triangle : mesh.triangles) {
    bytes.push_back(3);
    for (const std::int32_t corner : triangle) append_value(bytes, corner);
  }
  write_file_atomically(path, bytes);
}

}  // namespace palpate::geometry
