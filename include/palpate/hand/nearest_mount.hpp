// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "palpate/hand/hand.hpp"

namespace palpate::hand {

/// Of all yaws, pitches and rolls (rad) that make a pose, those nearest to given ones: a mount
/// whose angles are unbounded does not swing round where only the pose is given. Where the pitch is
/// a quarter turn, yaw and roll share what they make together evenly.
MountPosition nearest_mount(const Eigen::Isometry3d& T_world_mount, const MountPosition& near);

}  // namespace palpate::hand
