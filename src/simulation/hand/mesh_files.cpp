// SPDX-License-Identifier: Apache-2.0
#include "simulation/hand/mesh_files.hpp"

#include <fmt/format.h>

#include <algorithm>
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
  for (fs::path above = folder; above != above.parent_path(); above = above.parent_path()) {
    if (is_file(above / within)) return above / within;  // a package in a folder of another name
  }
  for (const fs::path& path : {mesh.filename(), "meshes" / mesh.filename()}) {
    if (is_file(folder / path)) return folder / path;
  }
  throw BadInput(fmt::format(
      "the mesh {} is neither in a folder {} nor as {} from {} upwards, nor there as {} "
      "or meshes/{}",
      shown(mesh), shown(package), shown(within), folder.string(), shown(mesh.filename()),
      shown(mesh.filename())));
}

/// Where a mesh is, by the rules of the file that it is from. The simulator looks for names without
/// a scheme in the same places.
fs::path find_mesh(const mjsMesh& mesh, const std::string& name, const fs::path& file) {
  const mjSpec& origin = *mjs_getOriginSpec(mesh.element);
  const auto scheme = name.find(kScheme);
  if (scheme == name.npos || origin.strippath) {
    const fs::path stated = origin.strippath ? fs::path(name).filename() : fs::path(name);
    return fs::path(mjs_getString(origin.modelfiledir)) /
           mjs_getString(mjs_getCompiler(mesh.element)->meshdir) / stated;
  }
  const std::string path = name.substr(scheme + kScheme.size());
  if (name.starts_with("http")) {
    throw BadInput(fmt::format("the mesh {} is not on this machine: fetch it, and name the file",
                               shown(name)));
  }
  return name.starts_with("file") ? fs::path(path) : in_package(path, file);
}

std::string extension_of(const fs::path& path) {
  std::string extension = path.extension().string();
  for (char& c : extension) c = c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  return extension;
}

/// The first link that collides with a mesh; empty if none does.
std::string user_of(const mjSpec& spec, const mjsMesh& mesh) {
  const std::string name = mjs_getString(mjs_getName(mesh.element));
  for (mjsElement* e = mjs_firstElement(&spec, mjOBJ_GEOM); e; e = mjs_nextElement(&spec, e)) {
    const mjsGeom& geom = *mjs_asGeom(e);
    if (name != mjs_getString(geom.meshname) || (geom.contype == 0 && geom.conaffinity == 0)) {
      continue;
    }
    return mjs_getString(mjs_getName(mjs_getParent(e)->element));
  }
  return {};
}

std::string first_bytes(const fs::path& path, std::size_t count) {
  std::string bytes(count, 0);
  std::ifstream stream(path, std::ios::binary);
  stream.read(bytes.data(), static_cast<std::streamsize>(count));
  bytes.resize(static_cast<std::size_t>(std::max<std::streamsize>(0, stream.gcount())));
  return bytes;
}

/// @throws BadInput where a link collides with a mesh that cannot be read
void refuse_unreadable(const std::string& link, const fs::path& path) {
  constexpr std::array<std::string_view, 4> kRead = {".stl", ".obj", ".msh", ".ply"};
  const std::string mesh = fmt::format("the mesh {} of link {}", shown(path), link);
  if (!is_file(path)) throw BadInput(mesh + " does not exist");
  if (first_bytes(path, 24).starts_with("version https://git-lfs")) {
    throw BadInput(mesh + " is a pointer of Git LFS, not the mesh: run `git lfs pull`");
  }
  if (std::ranges::find(kRead, extension_of(path)) != kRead.end()) return;
  throw BadInput(mesh + " is of a format that is not read: convert it to STL or OBJ");
}

/// Whether an STL file is of text, not of numbers in binary. Some of the latter begin alike.
bool is_text_stl(const fs::path& path) {
  if (extension_of(path) != ".stl") return false;
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
  for (mjsElement* e = mjs_firstElement(&spec, mjOBJ_MESH); e; e = mjs_nextElement(&spec, e)) {
    mjsMesh& mesh = *mjs_asMesh(e);
    const std::string name = mjs_getString(mesh.file);
    if (name.empty()) continue;
    const fs::path path = find_mesh(mesh, name, file);
    if (const std::string link = user_of(spec, mesh); !link.empty()) refuse_unreadable(link, path);
    if (is_text_stl(path) || (extension_of(path) == ".ply" && is_file(path))) {
      read_here(mesh, path);
    } else if (name.find(kScheme) != name.npos && !mjs_getOriginSpec(e)->strippath) {
      mjs_setString(mesh.file, path.c_str());
    }
  }
}

}  // namespace palpate::simulation
