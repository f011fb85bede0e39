// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "palpate/core/progress.hpp"
#include "palpate/hand/description.hpp"

namespace palpate::grasping {

inline constexpr double kSteepest = 1.45;  ///< rad of pitch; at pi/2 yaw and roll are one

/// A closing actuator so far on its way from straight to closed, rad.
double bent(const hand::Actuator& actuator, double share);

/// Searches the open hand and the attitudes in which closing it holds objects of household size
/// best, and sets the speeds at which the actuators close. What was found is kept in the cache.
/// @throws BadInput if no posture holds anything
hand::Preshape find_preshape(hand::Description& hand, const ProgressCallback& progress);

}  // namespace palpate::grasping
