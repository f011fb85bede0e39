// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include "palpate/core/error.hpp"
#include "simulation/rendering/drawn_scene.hpp"
#include "simulation/world/mesh_geom.hpp"

namespace palpate::simulation {
namespace {

constexpr std::size_t kMaxGhosts = 500;
constexpr double kSolid = 0.9;  // opacity from which a ghost throws a shadow
const Eigen::Vector3f kGhostColor(0.16f, 0.38f, 0.86f);

void check_opacity(double opacity) {
  if (opacity >= 0 && opacity <= 1) return;
  throw BadInput(fmt::format("an opacity of {} is not within 0..1", opacity));
}

void add_ghost(const mjModel& model, int geom, const Ghost& ghost, mjvScene& drawn) {
  const Eigen::Isometry3d T =
      ghost.T_world_object * pose3(model.geom_pos + 3 * geom, model.geom_quat + 4 * geom);
  const Eigen::Vector3d p = T.translation();
  const Eigen::Matrix<double, 3, 3, Eigen::RowMajor> R = T.linear();
  const float rgba[] = {kGhostColor.x(), kGhostColor.y(), kGhostColor.z(),
                        static_cast<float>(ghost.opacity)};
  if (drawn.ngeom >= drawn.maxgeom) return;
  mjvGeom& added = drawn.geoms[drawn.ngeom++];
  mjv_initGeom(&added, mjGEOM_MESH, nullptr, p.data(), R.data(), rgba);
  added.dataid = 2 * model.geom_dataid[geom];  // the mesh itself; the next one is its convex hull
  added.category = ghost.opacity < kSolid ? mjCAT_DECOR : mjCAT_DYNAMIC;  // decor has no shadow
}

/// An object that is not there has no shadow either.
void fade_object(int object_geom, double opacity, mjvScene& drawn) {
  for (int i = 0; i < drawn.ngeom; ++i) {
    mjvGeom& geom = drawn.geoms[i];
    if (geom.objtype != mjOBJ_GEOM || geom.objid != object_geom) continue;
    geom.rgba[3] = static_cast<float>(opacity);
    if (opacity == 0) geom = drawn.geoms[--drawn.ngeom];
    return;
  }
}

}  // namespace

void draw_ghosts(const DrawnScene& scene, const DrawnState& state, mjvScene& drawn) {
  if (state.ghosts.size() > kMaxGhosts) {
    throw BadInput(
        fmt::format("{} ghosts to draw; {} are possible", state.ghosts.size(), kMaxGhosts));
  }
  check_opacity(state.object_opacity);
  fade_object(scene.object_geom, state.object_opacity, drawn);
  for (const Ghost& ghost : state.ghosts) {
    check_opacity(ghost.opacity);
    if (!ghost.T_world_object.matrix().allFinite()) {
      throw BadInput("cannot draw a ghost whose pose is not finite");
    }
    add_ghost(*scene.model, scene.object_geom, ghost, drawn);
  }
}

}  // namespace palpate::simulation
