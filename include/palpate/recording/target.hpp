// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <vector>

#include "palpate/recording/recording.hpp"

namespace palpate::recording {

/// Where the object was to be brought, as known at a time: the last note `target` until then, if
/// there is one. T_world_object.
/// @throws BadInput if that is no pose
std::optional<Eigen::Isometry3d> target_at(const std::vector<Event>& events, double time);

}  // namespace palpate::recording
