// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "palpate/registration/pose.hpp"

namespace palpate::registration {

/// Rotation that minimises r~' Q~ r~ among the allowed ones, that about an axis by all minima of
/// the cost over the angle.
/// @param turns  not all()
Eigen::Matrix3d solve_limited_rotation(const Matrix10d& objective, const AllowedTurns& turns);

/// Projector on the turns that are not allowed, 0 if all are.
Eigen::Matrix3d excluded_turns(const AllowedTurns& turns);

/// Basis of the allowed twists [w; v], one a column: turns first, then the three shifts.
Eigen::Matrix<double, 6, Eigen::Dynamic> allowed_twists(const AllowedTurns& turns);

}  // namespace palpate::registration
