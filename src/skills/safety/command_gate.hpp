// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>

#include "palpate/hand/hand.hpp"
#include "palpate/skills/safety.hpp"

namespace palpate::skills {

/// `to`, or the point on the way there that is as far from `from` as a step may be.
/// @param step  >= 0, in the units of both
Eigen::Vector3d limited_step(const Eigen::Vector3d& from, const Eigen::Vector3d& to, double step);

/// A straight motion from rest to rest in whole ticks, with trapezoidal speed.
class SpeedProfile {
 public:
  /// @param seconds  that are wanted; limit() makes it longer
  explicit SpeedProfile(double seconds);

  /// @param way  m or rad, of something that moves along
  void limit(double way, double max_speed, double max_acceleration);

  /// Takes that many times as long, if more than 1, with accelerations smaller by its square.
  void stretch(double times);

  [[nodiscard]] int ticks() const { return steady_ + ramp() - 1; }
  /// Share of the way after that many ticks, 0..1.
  [[nodiscard]] double share(int tick) const;

 private:
  /// Ticks to full speed.
  [[nodiscard]] int ramp() const;

  int steady_;           // ticks that the way takes at full speed
  double ramp_way_ = 0;  // way / acceleration, s^2
};

/// Lets through what the hand may be commanded: targets within the actuators' ranges and the
/// workspace that are no farther from those before than speed and acceleration allow. To stop or to
/// slow down is always allowed at once; a mount that turns back starts from rest. A finger, whose
/// torque is limited, may turn back at the speed that it had.
class CommandGate {
 public:
  CommandGate(const std::vector<hand::Actuator>& actuators, const hand::HandCommand& start,
              const SafetyOptions& options);

  /// @throws BadInput for a value that is not finite, or not one an actuator
  [[nodiscard]] hand::HandCommand limited(const hand::HandCommand& wanted);

  /// The last command that was let through; at first, where the hand is.
  [[nodiscard]] const hand::HandCommand& last() const { return last_; }
  /// The last command counts as one that much higher (m): the world's origin has moved.
  void raise(double height) { last_.mount.xyz.z() += height; }
  /// Commands that had to be changed, so far.
  [[nodiscard]] std::size_t changed() const { return changed_; }

 private:
  void limit_mount(hand::MountPosition& mount);
  void limit_fingers(hand::ActuatorVector& positions);

  std::vector<hand::Actuator> actuators_;
  SafetyOptions options_;
  hand::HandCommand last_;
  Eigen::Vector3d slide_ = Eigen::Vector3d::Zero(), turn_ = slide_;  // m/s, rad/s, of the last
  hand::ActuatorVector finger_speeds_;
  std::size_t changed_ = 0;
};

}  // namespace palpate::skills
