// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "palpate/geometry/query/mesh_query.hpp"
#include "palpate/recording/recording.hpp"
#include "sense.hpp"

namespace palpate::app {

/// Outward normal at which a round tip touches the true object: from the surface's nearest point to
/// the tip's centre (world). The sensed point itself, off by millimetres, may lie nearest to the
/// other face of an edge or the other side of a thin wall. Nothing where the frame lacks the truth
/// or the tip is nowhere near the object.
std::optional<Eigen::Vector3d> true_normal(const geometry::MeshQuery& mesh,
                                           const recording::Frame& frame,
                                           const Eigen::Vector3d& tip_center);

/// Normals and forces of every finger that touches something in a recording of this project. The
/// truth, where the recording has it, is the normal at which the tip touches it.
std::vector<SensedStream> sense_recording(const SenseArguments& arguments);

/// Normals and forces of every finger in a CSV of contacts, judged by its own normals.
std::vector<SensedStream> sense_contact_log(const SenseArguments& arguments);

}  // namespace palpate::app
