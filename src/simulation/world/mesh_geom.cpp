// SPDX-License-Identifier: Apache-2.0
#include "simulation/world/mesh_geom.hpp"

#include <vector>

#include "simulation/hand/hand_spec.hpp"

namespace palpate::simulation {
namespace {

void add_asset(mjSpec& spec, const std::string& name, const geometry::TriangleMesh& mesh) {
  std::vector<float> vertices;
  for (const Eigen::Vector3d& v : mesh.vertices) {
    for (int k = 0; k < 3; ++k) vertices.push_back(static_cast<float>(v[k]));
  }
  std::vector<int> faces;
  for (const auto& t : mesh.triangles) faces.insert(faces.end(), t.begin(), t.end());
  mjsMesh* asset = mjs_addMesh(&spec, mjs_getSpecDefault(&spec));
  set_name(asset->element, name);
  asset->inertia = mjMESH_INERTIA_SHELL;  // unused, but that of a thin part's volume would fail
  mjs_setFloat(asset->uservert, vertices.data(), static_cast<int>(vertices.size()));
  mjs_setInt(asset->userface, faces.data(), static_cast<int>(faces.size()));
}

}  // namespace

mjsGeom& add_mesh(mjSpec& spec, mjsBody& body, const std::string& name,
                  const geometry::TriangleMesh& mesh) {
  add_asset(spec, name, mesh);
  mjsGeom* geom = mjs_addGeom(&body, mjs_getSpecDefault(&spec));
  set_name(geom->element, name);
  mjs_setString(geom->meshname, name.c_str());
  geom->type = mjGEOM_MESH;
  return *geom;
}

}  // namespace palpate::simulation
