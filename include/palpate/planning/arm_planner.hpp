// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <string>

#include "palpate/hand/arm.hpp"
#include "palpate/planning/planner.hpp"

namespace palpate::planning {

/// An arm and the mount that it carries, as they are commanded.
struct ArmStart {
  hand::ArmPosture posture;   ///< of an arm
  hand::MountPosition mount;  ///< in the world of the plan, whose table is at z = 0
  double table_height = 0;    ///< m, of that table in the world of the arm
};

/// Why the arm cannot bring the mount to the start of a line, in whatever posture, and from there
/// along it; empty: it can. @throws BadInput as plan_with_arm()
std::string arm_obstacle(const ArmStart& start, std::span<const hand::MountPosition> line);

/// A collision-free motion of mount and arm to the start of a line, in a posture of the arm from
/// which the mount can then be brought along the line. The hand keeps its joints.
///
/// Sampling-based search with OMPL, as plan(), in the space of the arm's joints, with collisions of
/// the arm with itself and the table (hand::arm_collision), and of the hand and what it holds. The
/// arm keeps within the limits of its joints, the mount within those of the options. The mount's
/// pose is taken to be off by a constant in its own frame from that of the arm's kinematics.
/// @param joints  of the hand, rad
/// @return of status no_path where arm_obstacle() has one, or none was found
/// @throws BadInput for an unknown planner, an empty line, no arm, or one that has not as many
///         joints as its posture
Plan plan_with_arm(const ArmStart& start, std::span<const hand::MountPosition> line,
                   const hand::JointVector& joints, CollisionChecker& scene,
                   const PlanOptions& options, std::uint64_t seed);

}  // namespace palpate::planning
