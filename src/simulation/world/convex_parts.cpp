// SPDX-License-Identifier: Apache-2.0
#include "palpate/simulation/world/convex_parts.hpp"

#include <fmt/format.h>

#include <cstring>
#include <mutex>
#include <string>
#include <string_view>
#include <utility>

#include "palpate/core/cache.hpp"
#include "palpate/core/error.hpp"
#include "palpate/geometry/repair/mesh_repair.hpp"
#include "simulation/world/coacd.hpp"
#include "simulation/world/decimation.hpp"

namespace palpate::simulation {
namespace {

constexpr double kConcavity = 0.05;
constexpr int kHullVertices = 256;
constexpr unsigned kSeed = 0;
// The time of the decomposition grows with the triangles; its concavity is coarser by far.
constexpr std::size_t kTriangles = 3000;
constexpr double kDecimation = 0.0004;   // m
constexpr std::size_t kMaxBodies = 200;  // more make contacts slow, and are no object to hold

std::vector<double> flat_vertices(const geometry::TriangleMesh& mesh) {
  std::vector<double> result;
  for (const Eigen::Vector3d& v : mesh.vertices) result.insert(result.end(), v.begin(), v.end());
  return result;
}

std::vector<int> flat_triangles(const geometry::TriangleMesh& mesh) {
  std::vector<int> result;
  for (const auto& t : mesh.triangles) result.insert(result.end(), t.begin(), t.end());
  return result;
}

geometry::TriangleMesh mesh_from(const CoACD_Mesh& part) {
  geometry::TriangleMesh mesh;
  for (std::uint64_t i = 0; i < part.vertices_count; ++i) {
    mesh.vertices.emplace_back(part.vertices_ptr + 3 * i);
  }
  for (std::uint64_t i = 0; i < part.triangles_count; ++i) {
    const int* const t = part.triangles_ptr + 3 * i;
    mesh.triangles.push_back({t[0], t[1], t[2]});
  }
  return mesh;
}

/// Vertices and triangles as bytes, each with their count before them.
void append(std::string& bytes, const geometry::TriangleMesh& mesh) {
  const auto add = [&bytes](const auto& values) {
    const std::uint64_t count = values.size();
    bytes.append(reinterpret_cast<const char*>(&count), sizeof count);
    bytes.append(reinterpret_cast<const char*>(values.data()), count * sizeof values[0]);
  };
  add(flat_vertices(mesh));
  add(flat_triangles(mesh));
}

/// Takes values off the front of the bytes; false if there are too few.
template <typename Value>
bool take(std::string_view& bytes, std::vector<Value>& values) {
  std::uint64_t count = 0;
  if (bytes.size() < sizeof count) return false;
  std::memcpy(&count, bytes.data(), sizeof count);
  bytes.remove_prefix(sizeof count);
  if (bytes.size() / sizeof(Value) < count) return false;
  values.resize(count);
  std::memcpy(values.data(), bytes.data(), count * sizeof(Value));
  bytes.remove_prefix(count * sizeof(Value));
  return true;
}

std::vector<geometry::TriangleMesh> read_parts(std::string_view bytes) {
  std::vector<geometry::TriangleMesh> parts;
  std::vector<double> vertices;
  std::vector<int> triangles;
  while (take(bytes, vertices) && take(bytes, triangles)) {
    parts.push_back(
        mesh_from({vertices.data(), vertices.size() / 3, triangles.data(), triangles.size() / 3}));
  }
  return parts;
}

std::string cache_key(const std::vector<geometry::TriangleMesh>& bodies) {
  std::string key =
      fmt::format("convex parts 3: CoACD, concavity {}, {} vertices, seed {}, {} triangles, {} m\n",
                  kConcavity, kHullVertices, kSeed, kTriangles, kDecimation);
  for (const geometry::TriangleMesh& body : bodies) append(key, body);
  return key;
}

/// The connected bodies of the mesh, without its closed cavities, which nothing can reach. Those
/// that cross one another would take the decomposition of all at once very long.
std::vector<geometry::TriangleMesh> bodies_of(const geometry::TriangleMesh& mesh) {
  auto bodies = geometry::components(mesh);
  if (bodies.size() == 1) return {mesh};  // its vertices in their own order
  std::erase_if(bodies, [](const auto& body) { return geometry::inspect(body).volume < 0; });
  if (bodies.size() > kMaxBodies) {
    throw BadInput(fmt::format("an object of {} separate bodies cannot be simulated: at most {}",
                               bodies.size(), kMaxBodies));
  }
  return bodies;
}

std::vector<geometry::TriangleMesh> decompose(const geometry::TriangleMesh& mesh) {
  std::vector<double> vertices = flat_vertices(mesh);
  std::vector<int> triangles = flat_triangles(mesh);
  const CoACD_Mesh input = {vertices.data(), mesh.vertices.size(), triangles.data(),
                            mesh.triangles.size()};
  // The library keeps its random state and its log in globals.
  static std::mutex mutex;
  const std::scoped_lock lock(mutex);
  CoACD_setLogLevel("off");
  const CoACD_MeshArray parts =
      CoACD_run(&input, kConcavity, /*max_convex_hull=*/-1, /*preprocess_mode=*/2,
                /*preprocess_resolution=*/50, /*sample_resolution=*/2000, /*mcts_nodes=*/20,
                /*mcts_iterations=*/150, /*mcts_max_depth=*/3, /*pca=*/false, /*merge=*/true,
                /*decimate=*/true, kHullVertices, /*extrude=*/false, /*extrude_margin=*/0.01,
                /*approximation_mode=*/0, kSeed, /*real_metric=*/false);
  std::vector<geometry::TriangleMesh> result;
  for (std::uint64_t i = 0; i < parts.meshes_count; ++i) {
    result.push_back(mesh_from(parts.meshes_ptr[i]));
  }
  CoACD_freeMeshArray(parts);
  return result;
}

}  // namespace

std::vector<geometry::TriangleMesh> convex_parts(const geometry::TriangleMesh& mesh) {
  if (mesh.triangles.empty()) throw BadInput("a mesh of 0 triangles has no convex parts");
  const auto bodies = bodies_of(mesh);
  const std::string key = cache_key(bodies);
  if (const auto kept = read_cache(key)) return read_parts(*kept);
  std::vector<geometry::TriangleMesh> parts;
  for (const geometry::TriangleMesh& body : bodies) {
    for (auto& part : decompose(decimated(body, kTriangles, kDecimation))) {
      parts.push_back(std::move(part));
    }
  }
  if (parts.empty()) {
    throw BadInput(
        fmt::format("no convex part found in a mesh of {} triangles", mesh.triangles.size()));
  }
  std::string bytes;
  for (const geometry::TriangleMesh& part : parts) append(bytes, part);
  write_cache(key, bytes);
  return parts;
}

}  // namespace palpate::simulation
