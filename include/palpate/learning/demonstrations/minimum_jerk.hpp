// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

namespace palpate::learning {

/// Positions with their first two derivatives in time, a column a sample.
struct Motion {
  Eigen::MatrixXd position, velocity, acceleration;
  double step = 0;  ///< s between samples
};

/// The motion that comes closest to given points with little jerk: it minimises
/// sum |q(t_i) - y_i|^2 + weight * integral |q'''|^2 dt, so q''' is about zero (thesis 7.2.2).
/// @param times      s, rising, one for each column of `points`; the motion ends at the last
/// @param smoothing  s; 0 goes through the points, larger ones average over about this time
/// @param step       s between the samples of the motion
/// @throws BadInput if there is no point, sizes differ, times do not rise, a value is not finite,
///         or step is not positive
Motion minimum_jerk(const Eigen::VectorXd& times, const Eigen::MatrixXd& points, double smoothing,
                    double step);

/// Share of the way, 0..1, at a share of the time: the motion from rest to rest with the least jerk
/// (Flash & Hogan 1985).
double minimum_jerk_share(double time);

}  // namespace palpate::learning
