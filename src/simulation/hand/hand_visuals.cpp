// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <numeric>
#include <utility>

#include "palpate/simulation/hand/load_hand.hpp"
#include "simulation/hand/geom_mesh.hpp"
#include "simulation/hand/hand_model.hpp"
#include "simulation/hand/hand_spec.hpp"

namespace palpate::simulation {
namespace {

bool is_visual(const mjModel& model, int geom) {
  return model.geom_type[geom] == mjGEOM_MESH && model.geom_contype[geom] == 0;
}

/// The meshes that are only there to be seen, or, in a file without any, all shapes.
std::vector<int> drawn_geoms(const mjModel& model) {
  std::vector<int> all(static_cast<std::size_t>(model.ngeom));
  std::iota(all.begin(), all.end(), 0);
  std::vector<int> visual;
  std::ranges::copy_if(all, std::back_inserter(visual),
                       [&](int geom) { return is_visual(model, geom); });
  return visual.empty() ? all : visual;
}

std::string name_of_mesh(const mjModel& model, int geom) {
  if (model.geom_type[geom] != mjGEOM_MESH) return fmt::format("geom {}", geom);
  return mj_id2name(&model, mjOBJ_MESH, model.geom_dataid[geom]);
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
  for (const int geom : drawn_geoms(*model)) {
    const std::string name = name_of_mesh(*model, geom);
    if (!visuals.meshes.contains(name)) {
      auto mesh = geom_mesh(*model, geom);
      if (mesh.triangles.empty()) continue;
      visuals.meshes[name] = std::move(mesh);
    }
    visuals.parts.push_back(
        {.link = links[static_cast<std::size_t>(model->geom_bodyid[geom])],
         .mesh = name,
         .T_link_mesh = pose3(model->geom_pos + 3 * geom, model->geom_quat + 4 * geom),
         .color = color_of(*model, geom)});
  }
  return visuals;
}

}  // namespace palpate::simulation
