// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Geometry>

#include "palpate/estimation/estimate.hpp"
#include "palpate/skills/executor.hpp"

namespace palpate::skills {

/// How an object stands on a table, other than its mesh would in the stable pose.
struct Standing {
  Eigen::Isometry3d T_flat_object = Eigen::Isometry3d::Identity();  ///< where it is, laid flat
  double lean = 0;     ///< rad, expected, from the stable pose
  double upright = 1;  ///< probability that it leans by less than asked for
};

/// What to expect of an object that has been seen to stand, and will be put down alike. A rounded
/// body whose centre of mass is off leans there, too; a tilt of what cannot lean is an error of the
/// estimate. The lean is normal as far as geometry::RestingSlack has it, or, with a probability of
/// 0.1, 0.2 rad (sigma): a centre of mass that is off may put it onto a side on which its mesh
/// would not stay.
/// @param T_world_object  as estimated, z up
/// @param tilt_error  rad, of that about each horizontal axis
/// @param options  errors of surface and centre of mass
/// @param most  rad
Standing standing_of(const geometry::ObjectModel& object, const Eigen::Isometry3d& T_world_object,
                     double tilt_error, const estimation::EstimationOptions& options, double most);

/// The same of an object that hangs in the hand, as it stood when the hand had closed: it has moved
/// in the hand since, as far as the fingers tell.
/// @param T_mount_object  in the lifted hand
Standing as_it_stood(const geometry::ObjectModel& object, const Executor& robot,
                     const Eigen::Isometry3d& T_mount_object,
                     const estimation::EstimationOptions& options, double most);

/// Probability that an object that was not seen to stand in a stable pose will lean there by less
/// than `most` (rad).
double upright_probability(const geometry::ObjectModel& object, std::size_t stable_pose,
                           const estimation::EstimationOptions& options, double most);

}  // namespace palpate::skills
