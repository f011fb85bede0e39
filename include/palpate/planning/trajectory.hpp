// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "palpate/hand/hand.hpp"

namespace palpate::planning {

/// Mount x, y, z (m), yaw, pitch, roll (rad) and the actuators (rad): all that a path moves.
inline constexpr int kMountCoordinates = 6;
using Coordinates =
    Eigen::Matrix<double, Eigen::Dynamic, 1, 0, kMountCoordinates + hand::kMaxJoints, 1>;

Coordinates coordinates_of(const hand::HandCommand& command);
hand::HandCommand command_of(const Coordinates& coordinates);

/// How fast the hand may move, each coordinate by itself.
struct MotionLimits {
  double mount_speed = 0.25;         ///< m/s, along each axis
  double mount_acceleration = 1.0;   ///< m/s^2, along each axis
  double turn_speed = 1.0;           ///< rad/s, of each angle of the mount
  double turn_acceleration = 4.0;    ///< rad/s^2, of each angle of the mount
  double joint_speed = 2.0;          ///< rad/s
  double joint_acceleration = 10.0;  ///< rad/s^2

  template <class Visitor>
  void visit(Visitor&& v) {
    v("mount_speed", mount_speed, 0.001, 10.0, "m/s, largest speed of the mount along each axis");
    v("mount_acceleration", mount_acceleration, 0.001, 100.0,
      "m/s^2, largest acceleration of the mount along each axis");
    v("turn_speed", turn_speed, 0.001, 50.0,
      "rad/s, largest rate of each of the mount's yaw, pitch and roll");
    v("turn_acceleration", turn_acceleration, 0.001, 500.0,
      "rad/s^2, largest acceleration of each of the mount's yaw, pitch and roll");
    v("joint_speed", joint_speed, 0.001, 50.0, "rad/s, largest speed of a joint");
    v("joint_acceleration", joint_acceleration, 0.001, 500.0,
      "rad/s^2, largest acceleration of a joint");
  }
};

/// The limits by coordinate.
/// @param size  number of coordinates
Coordinates speed_limits(const MotionLimits& limits, Eigen::Index size);
Coordinates acceleration_limits(const MotionLimits& limits, Eigen::Index size);

/// A straight line or the arc of a parabola, over a path length u in 0..length (m, see metric()):
/// start + u direction + u^2/2 bend.
struct PathPiece {
  Coordinates start, direction;
  Coordinates bend;
  double length = 0;

  [[nodiscard]] Coordinates at(double u) const {
    return start + u * direction + 0.5 * u * u * bend;
  }
  [[nodiscard]] Coordinates tangent(double u) const { return direction + u * bend; }
};

/// Metres of path a unit of each coordinate: about how far it moves the farthest fingertip.
Coordinates metric(const hand::Description& hand);

/// Length (m) of the way between two configurations: the norm of the difference times the metric.
double distance(const Coordinates& a, const Coordinates& b, const Coordinates& metric);

/// The polyline with its corners cut by parabolas: a path with a continuous direction.
///
/// As Kunz & Stilman, RSS 2012, with parabolas in place of circles. A cut starts and ends at most
/// `cut[i]` (m of path) from corner i, and never beyond the middle of a side; 0 keeps the corner,
/// where the motion must then stop.
/// @param corners  at least two, each different from the next
/// @param cuts  one a corner; those of the two ends mean nothing
std::vector<PathPiece> rounded(const std::vector<Coordinates>& corners,
                               const std::vector<double>& cuts, const Coordinates& metric);

/// Times of the grid along a path, from rest to rest, as fast as the limits allow.
///
/// Reachability analysis of the squared path speed (Pham & Pham, T-RO 2018): a backward pass finds
/// the largest from which the end can be reached, a forward pass takes the largest acceleration.
/// Within a stage the acceleration along the path is constant.
/// @return positions at 0, dt, 2 dt, ... and at last the end
std::vector<Coordinates> time_path(const std::vector<PathPiece>& path, const MotionLimits& limits,
                                   const Coordinates& metric, double dt = hand::kTick);

/// Largest speed and acceleration of each coordinate.
struct CoordinateLimits {
  Coordinates speed, acceleration;
};

/// The same for any coordinates, such as an arm's joints.
std::vector<Coordinates> time_path(const std::vector<PathPiece>& path,
                                   const CoordinateLimits& limits, const Coordinates& metric,
                                   double dt = hand::kTick);

}  // namespace palpate::planning
