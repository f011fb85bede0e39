// SPDX-License-Identifier: Apache-2.0
#include "palpate/simulation/hand/load_hand.hpp"
#include "simulation/hand/hand_model.hpp"
#include "simulation/hand/hand_spec.hpp"

namespace palpate::simulation {
namespace {

bool is_drawn(const mjModel& model, int geom) {
  return model.geom_type[geom] == mjGEOM_MESH && model.geom_contype[geom] == 0;
}

geometry::TriangleMesh read_mesh(const mjModel& model, int mesh) {
  geometry::TriangleMesh result;
  const float* const vertices = model.mesh_vert + 3 * model.mesh_vertadr[mesh];
  for (int i = 0; i < model.mesh_vertnum[mesh]; ++i) {
    result.vertices.push_back(Eigen::Vector3f(vertices + 3 * i).cast<double>());
  }
  const int* const faces = model.mesh_face + 3 * model.mesh_faceadr[mesh];
  for (int i = 0; i < model.mesh_facenum[mesh]; ++i) {
    result.triangles.push_back({faces[3 * i], faces[3 * i + 1], faces[3 * i + 2]});
  }
  return result;
}

Eigen::Vector3d color_of(const mjModel& model, int geom) {
  const int material = model.geom_matid[geom];
  const float* const rgba =
      material >= 0 ? model.mat_rgba + 4 * material : model.geom_rgba + 4 * geom;
  return Eigen::Vector3f(rgba).cast<double>();
}

}  // namespace

hand::HandVisuals load_hand_visuals(const hand::Description& hand) {
  const SpecHandle spec = parse_hand(hand);
  const ModelHandle model = compile(*spec);
  const auto links = links_of_bodies(*model, find_id(*model, mjOBJ_BODY, hand.file.root));
  hand::HandVisuals visuals;
  for (int geom = 0; geom < model->ngeom; ++geom) {
    if (!is_drawn(*model, geom)) continue;
    const int mesh = model->geom_dataid[geom];
    const std::string name = mj_id2name(model.get(), mjOBJ_MESH, mesh);
    if (!visuals.meshes.contains(name)) visuals.meshes[name] = read_mesh(*model, mesh);
    visuals.parts.push_back(
        {.link = links[static_cast<std::size_t>(model->geom_bodyid[geom])],
         .mesh = name,
         .T_link_mesh = pose3(model->geom_pos + 3 * geom, model->geom_quat + 4 * geom),
         .color = color_of(*model, geom)});
  }
  return visuals;
}

}  // namespace palpate::simulation
