// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "palpate/hand/hand.hpp"

namespace palpate::skills {

/// Base position with a pose, turned the shorter way from `near`.
hand::BasePosition base_near(const Eigen::Isometry3d& T_world_base, const hand::BasePosition& near);

}  // namespace palpate::skills
