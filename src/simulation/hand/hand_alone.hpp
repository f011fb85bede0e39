// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "simulation/world/mujoco_handles.hpp"

namespace palpate::simulation {

/// @throws BadInput, naming both, where something in a parsed file refers to what the file lacks
void refuse_broken_references(mjSpec& spec);

/// Leaves the hand alone in a parsed file: its root, without joints of its own, is the world's only
/// body and in no frame. What is above and beside it goes, with all that refers to it.
/// @throws BadInput if the root is missing or is the world
void keep_hand_only(mjSpec& spec, const std::string& root);

/// Removes tendons, and the equalities and actuators of tendons.
void remove_tendons(mjSpec& spec);

/// Takes a body or a geom out of the frames around it: its pose is that in its parent then.
void leave_frames(mjsBody& parent, mjsElement& element);

/// Where a geom stands in its body, of the frames around it too, and of `fromto`.
Eigen::Vector3d middle_in_body(const mjsGeom& geom);

}  // namespace palpate::simulation
