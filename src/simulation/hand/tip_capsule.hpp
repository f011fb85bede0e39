// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "palpate/hand/description.hpp"
#include "simulation/world/mujoco_handles.hpp"

namespace palpate::simulation {

/// Points of a geom's surface (corners, vertices), in its body's frame, m.
std::vector<Eigen::Vector3d> geom_points(const mjModel& model, int geom);

/// The capsule that stands for a fingertip: as long and wide as what the body's outermost geom that
/// collides has across and along the finger. Capsules and spheres are taken as they are.
/// @param p_base  where the finger comes from, in the body's frame, m
hand::TipCapsule fit_tip(const mjModel& model, int body, const Eigen::Vector3d& p_base);

}  // namespace palpate::simulation
