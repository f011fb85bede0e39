// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "palpate/hand/hand.hpp"

namespace palpate::skills {

/// Mount position with a pose, turned the shorter way from `near`.
hand::MountPosition mount_near(const Eigen::Isometry3d& T_world_mount,
                               const hand::MountPosition& near);

}  // namespace palpate::skills
