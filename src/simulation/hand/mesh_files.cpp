// SPDX-License-Identifier: Apache-2.0
#include "simulation/hand/mesh_files.hpp"

#include <fmt/format.h>

#include <array>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <string>
#include <string_view>

#include "palpate/core/error.hpp"
#include "palpate/geometry/io/mesh_io.hpp"
#include "simulation/hand/warnings.hpp"

namespace palpate::simulation {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kScheme = "://";

bool is_file(const fs::path& path) {
  std::error_code error;
  return fs::is_regular_file(path, error);
}

/// A name from the file as a message shows it.
std::string shown(const fs::path& path) {
  constexpr std::size_t kMost = 120;
  const std::string text = one_line(path.string());
  return text.size() > kMost ? text.substr(0, kMost) + "..." : text;
}

/// A mesh of a package (PACKAGE/PATH), in the package's folder or else beside the file.
/// @throws BadInput if it is nowhere
fs::path in_package(const fs::path& mesh, const fs::path& file) {
  const fs::path folder = fs::absolute(file).parent_path();
  for (fs::path above = folder;; above = above.parent_path()) {
    if (is_file(above / mesh)) return above / mesh;
    if (above == above.parent_path()) break;
  }
  const fs::path package = *mesh.begin();
  const fs::path within = mesh.lexically_relative(package);
  for (const fs::path& path : {within, mesh.filename(), "meshes" / mesh.filename()}) {
    if (is_file(folder / path)) return folder / path;
  }
  throw BadInput(fmt::format(
      "cannot read the hand {}: the mesh {} is neither in a folder {} from {} upwards, nor there "
      "as {}, {} or meshes/{}",
      file.string(), shown(mesh), shown(package), folder.string(), shown(within),
      shown(mesh.filename()), shown(mesh.filename())));
}

/// Where a mesh is. The simulator looks for names without a scheme in the same places.
fs::path find_mesh(const mjSpec& spec, const std::string& name, const fs::path& file) {
  const auto scheme = name.find(kScheme);
  if (scheme == name.npos) {
    return fs::path(mjs_getString(spec.modelfiledir)) / mjs_getString(spec.compiler.meshdir) / name;
  }
  const std::string path = name.substr(scheme + kScheme.size());
  return name.starts_with("file") ? fs::path(path) : in_package(path, file);
}

/// Whether an STL file is of text, not of numbers in binary. Some of the latter begin alike.
bool is_text_stl(const fs::path& path) {
  std::string extension = path.extension().string();
  for (char& c : extension) c = c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  if (extension != ".stl") return false;
  constexpr std::size_t kHeader = 80, kFacet = 50;
  std::array<char, kHeader + sizeof(std::uint32_t)> begin{};
  std::ifstream stream(path, std::ios::binary);
  if (!stream.read(begin.data(), begin.size())) return false;
  std::uint32_t triangles = 0;
  std::memcpy(&triangles, begin.data() + kHeader, sizeof(triangles));
  std::error_code error;
  const bool binary = fs::file_size(path, error) == begin.size() + kFacet * triangles;
  return !binary && std::string_view(begin.data(), begin.size()).starts_with("solid");
}

void read_here(mjsMesh& mesh, const fs::path& path) {
  const geometry::TriangleMesh read = geometry::load_mesh(path);
  std::vector<float> vertices;
  for (const Eigen::Vector3d& v : read.vertices) {
    for (const double value : v) vertices.push_back(static_cast<float>(value));
  }
  std::vector<int> faces;
  for (const auto& t : read.triangles) faces.insert(faces.end(), t.begin(), t.end());
  mjs_setFloat(mesh.uservert, vertices.data(), static_cast<int>(vertices.size()));
  mjs_setInt(mesh.userface, faces.data(), static_cast<int>(faces.size()));
  mjs_setString(mesh.file, "");
}

}  // namespace

void find_meshes(mjSpec& spec, const fs::path& file) {
  if (spec.strippath) return;  // beside the file
  for (mjsElement* e = mjs_firstElement(&spec, mjOBJ_MESH); e; e = mjs_nextElement(&spec, e)) {
    mjsMesh& mesh = *mjs_asMesh(e);
    const std::string name = mjs_getString(mesh.file);
    if (name.empty()) continue;
    const fs::path path = find_mesh(spec, name, file);
    if (is_text_stl(path)) {
      read_here(mesh, path);
    } else if (name.find(kScheme) != name.npos) {
      mjs_setString(mesh.file, path.c_str());
    }
  }
}

}  // namespace palpate::simulation
