// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>

#include "palpate/hand/description.hpp"
#include "simulation/world/mujoco_handles.hpp"

namespace palpate::simulation {

/// Points of a geom's surface (corners, vertices), in its body's frame, m.
std::vector<Eigen::Vector3d> geom_points(const mjModel& model, int geom);

/// The capsule that stands for a fingertip: as long and wide as what the body's outermost geom that
/// collides has across and along the finger. Capsules and spheres are taken as they are.
/// @param p_base  where the finger comes from, in the body's frame, m
hand::TipCapsule fit_tip(const mjModel& model, int body, const Eigen::Vector3d& p_base);

/// The convex hull of the fingertip's outermost geom, or, where that is only the end of it, of all
/// that its body collides with; as far as its capsule reaches along the finger, with edges of a
/// little radius. Nothing where the capsule is the surface.
/// @param capsule  of fit_tip()
std::optional<hand::TipHull> fit_hull(const mjModel& model, int body, const Eigen::Vector3d& p_base,
                                      const hand::TipCapsule& capsule);

/// Fits both. @param shape  HandNotes::tip_shape
/// @throws BadInput for a shape that is none
void fit_surface(const mjModel& model, int body, const Eigen::Vector3d& p_base,
                 const std::string& shape, hand::Finger& finger);

/// How far the shapes of a fingertip that its surface leaves out reach beyond it, m; not positive
/// if they do not.
double reach_beyond(const mjModel& model, int body, const Eigen::Vector3d& p_base,
                    const hand::Finger& finger);

}  // namespace palpate::simulation
