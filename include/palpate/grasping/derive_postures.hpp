// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "palpate/core/progress.hpp"
#include "palpate/hand/description.hpp"

namespace palpate::grasping {

/// Finds the postures that skills ask for, from kinematics and surface alone.
///
/// Fingers close by the actuators with hand::Actuator::closing, together. The open hand, the
/// thumb's place and the attitude of the mount are searched for by closing the hand virtually
/// around cylinders and boxes of household size on a table (plan_grasp()): the forces of the
/// fingertips are to balance. The flat hand is the attitude with the widest level underside, a
/// pointing one that in which one fingertip is farthest below all else.
/// @param hand  with links, actuators, fingers, thumb and mount; gets postures, closing speeds and
///              the ranges in which fingers bend
/// @param progress  called while the open hand is searched for, which takes about a minute; not
///                  called if it is in the cache
/// @throws BadInput if no posture of the hand holds anything
void derive_postures(hand::Description& hand, const ProgressCallback& progress = {});

}  // namespace palpate::grasping
