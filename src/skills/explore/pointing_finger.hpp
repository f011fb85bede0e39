// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "palpate/localization/information/guarded_move_choice.hpp"
#include "palpate/skills/executor.hpp"

namespace palpate::skills {

/// Mount position, turned by a yaw, that brings the probing fingertip to p (world).
hand::MountPosition mount_for_probe(const Executor& robot, const hand::PointingHand& pointing,
                                    double yaw, const Eigen::Vector3d& p);

/// m from the lowest part of the hand that points up to the centre of its fingertip.
double tip_above_lowest(const Executor& robot, const hand::PointingHand& pointing);

/// The probing finger's balls around the centre of its tip.
localization::ProbingFinger probing_finger(const Executor& robot,
                                           const hand::PointingHand& pointing, double yaw);

}  // namespace palpate::skills
