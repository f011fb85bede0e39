// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <map>
#include <vector>

#include "palpate/core/error.hpp"
#include "palpate/geometry/mesh/sampling.hpp"
#include "recording/base64.hpp"
#include "recording/matrix_json.hpp"
#include "recording/page_data.hpp"

namespace palpate::recording {
namespace {

using nlohmann::json;

constexpr std::size_t kFineMesh = 3000;       // vertices above which a mesh is coarsened
constexpr double kCellsAcrossDiagonal = 120;  // of its bounding box, when coarsened

geometry::TriangleMesh drawn(const geometry::TriangleMesh& mesh) {
  if (mesh.vertices.size() <= kFineMesh) return mesh;
  return geometry::simplified(mesh,
                              geometry::bounds(mesh).diagonal().norm() / kCellsAcrossDiagonal);
}

json mesh_to_json(const geometry::TriangleMesh& mesh) {
  std::vector<float> positions;
  std::vector<std::uint32_t> indices;
  for (const auto& vertex : mesh.vertices) {
    for (const double x : vertex) positions.push_back(static_cast<float>(x));
  }
  for (const auto& triangle : mesh.triangles) {
    for (const int v : triangle) indices.push_back(static_cast<std::uint32_t>(v));
  }
  return {{"positions", base64<float>(positions)}, {"indices", base64<std::uint32_t>(indices)}};
}

json part_to_json(const hand::VisualPart& part, std::size_t links,
                  const std::map<std::string, std::size_t>& mesh_index) {
  const auto mesh = mesh_index.find(part.mesh);
  if (mesh == mesh_index.end()) {
    throw BadInput(fmt::format("the hand's visuals have no mesh \"{}\"", part.mesh));
  }
  if (part.link < 0 || static_cast<std::size_t>(part.link) >= links) {
    throw BadInput(fmt::format("the hand's visuals draw link {} of {}", part.link, links));
  }
  return {{"link", part.link},
          {"mesh", mesh->second},
          {"T_link_mesh", pose_to_json(part.T_link_mesh)},
          {"color", matrix_to_json(part.color)}};
}

json spheres_to_json(const hand::Description& hand) {
  json spheres = json::array();
  for (const auto& sphere : hand.spheres) {
    spheres.push_back({{"link", sphere.link},
                       {"center", matrix_to_json(sphere.center)},
                       {"radius", sphere.radius}});
  }
  return spheres;
}

}  // namespace

json page_shapes(const Recording& recording, const hand::HandVisuals& visuals) {
  json meshes = json::array(), parts = json::array();
  meshes.push_back(mesh_to_json(drawn(recording.header.object.mesh)));
  std::map<std::string, std::size_t> mesh_index;
  for (const auto& [name, mesh] : visuals.meshes) {
    mesh_index[name] = meshes.size();
    meshes.push_back(mesh_to_json(drawn(mesh)));
  }
  for (const auto& part : visuals.parts) {
    parts.push_back(part_to_json(part, recording.header.hand.links.size(), mesh_index));
  }
  return {{"object_mesh", 0},
          {"meshes", meshes},
          {"parts", parts},
          {"spheres", parts.empty() ? spheres_to_json(recording.header.hand) : json::array()}};
}

}  // namespace palpate::recording
