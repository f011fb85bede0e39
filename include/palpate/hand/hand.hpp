// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <limits>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "palpate/core/se3.hpp"
#include "palpate/hand/biotac_reading.hpp"
#include "palpate/hand/description.hpp"

namespace palpate::hand {

inline constexpr double kTick = 0.01;  ///< s between readings

/// Number of ticks that is nearest to a time (s), at least one and at most 1e9; one for NaN.
int whole_ticks(double seconds);

/// One contact that a fingertip senses, in the frame of that finger's distal link.
struct TipContact {
  Eigen::Vector3d p;  ///< point, m
  Eigen::Vector3d n;  ///< outward unit normal of the object
  Eigen::Vector3d f;  ///< force of the finger on the object, N; f.n < 0
  /// What the sensor itself says of its error, standard deviations; 0: it says nothing.
  double point_sigma = 0;   ///< of the point across the surface, m
  double normal_sigma = 0;  ///< per tangent axis, rad
};

/// Position of the hand's 6-DoF mount: x, y, z (m), yaw, pitch, roll (rad).
struct MountPosition {
  Eigen::Vector3d xyz = Eigen::Vector3d::Zero();
  Eigen::Vector3d ypr = Eigen::Vector3d::Zero();

  /// T_world_mount = Trans(xyz) Rz(yaw) Ry(pitch) Rx(roll).
  Eigen::Isometry3d pose() const;

  /// The position of a pose, with a pitch of at most a quarter turn.
  static MountPosition at(const Eigen::Isometry3d& T_world_mount);
};

/// Between two positions, in each of the six coordinates. @param share  0: the first, 1: the second
MountPosition between(const MountPosition& a, const MountPosition& b, double share);

/// What the hand senses in one tick.
struct HandReading {
  double time = 0;         ///< s, when this was measured
  JointVector joints;      ///< rad
  ActuatorVector torques;  ///< N m, of the actuators, towards larger positions
  MountPosition mount;     ///< measured
  /// Force (N, world axes) of what carries the hand on the hand, less what holds the empty hand at
  /// rest: up (z > 0) when something hangs in the hand, down when the hand presses on the table.
  Eigen::Vector3d mount_force = Eigen::Vector3d::Zero();
  std::vector<std::vector<TipContact>> contacts;  ///< one entry a finger
  std::vector<BiotacReading> biotacs;  ///< one a finger; none where the tips have no BioTacs
};

/// Targets of the position controllers for the next tick.
struct HandCommand {
  ActuatorVector positions;  ///< rad
  MountPosition mount;
};

/// Whether what carries the hand can take its mount along a path.
struct PathFeasibility {
  std::string obstacle;      ///< why it cannot, in words; empty: it can
  std::size_t feasible = 0;  ///< positions before the obstacle, if there is one
  double stretch = 1;        ///< times as long as wanted these take, at least; 1: not longer
};

/// How gently the mount must be moved, where what carries the hand is stiff: its own inertia then
/// loads the sensor of the mount's load, and a touch is an impact.
struct MountLimits {
  double acceleration = std::numeric_limits<double>::infinity();       ///< m/s^2
  double turn_acceleration = std::numeric_limits<double>::infinity();  ///< rad/s^2
  double guarded_speed = std::numeric_limits<double>::infinity();      ///< m/s, towards a touch
};

struct ArmDescription;

/// How an arm holds the mount.
struct ArmPosture {
  const ArmDescription* arm = nullptr;  ///< the hand's own; none: only the mount is known
  std::vector<double> joints;           ///< rad, as commanded
};

/// A hand with tactile fingertips on a 6-DoF mount, simulated or real. What moves the mount is the
/// hand's own matter: a free-flying drive, or an arm (hand::ArmFollower). All calls are of one
/// thread; what they throw stops the robot.
class Hand {
 public:
  virtual ~Hand() = default;

  /// What the hand senses before any command. The executor asks once, at first, and commands
  /// nothing to a hand that stands elsewhere than it is said to; may wait until the hand is heard.
  /// @return nothing of a hand that senses in step() alone: its first command is given unseen
  virtual std::optional<HandReading> sense() { return std::nullopt; }

  /// Applies the command for one tick of kTick and returns what was sensed at its end.
  virtual HandReading step(const HandCommand& command) = 0;

  /// Whether the mount can be moved from where it is commanded to be along this path, one position
  /// a tick. A floating mount can be moved anywhere.
  [[nodiscard]] virtual PathFeasibility check_path(std::span<const MountPosition> path) const {
    static_cast<void>(path);
    return {};
  }

  [[nodiscard]] virtual MountLimits mount_limits() const { return {}; }

  /// The arm that carries the mount, for plans in the space of its joints. Of a hand that does not
  /// tell it, only the ways that check_path() accepts are taken.
  [[nodiscard]] virtual ArmPosture arm_posture() const { return {}; }
};

}  // namespace palpate::hand
