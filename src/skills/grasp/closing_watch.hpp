// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "palpate/hand/hand.hpp"
#include "skills/motion/touch_detector.hpp"

namespace palpate::skills {

/// What the actuators read while the fingers close on nothing: friction, which a torque that is
/// estimated from a motor's current holds. Measured while the closing sets out.
class ClosingFriction {
 public:
  explicit ClosingFriction(const hand::Description& hand)
      : torques_(hand::ActuatorVector::Zero(hand.actuator_count())) {}

  [[nodiscard]] bool known() const;
  [[nodiscard]] const hand::ActuatorVector& torques() const { return torques_; }

  void update(const hand::HandReading& reading);

  /// Limits of what is read with which the fingers press with no more than `contact_torque`.
  [[nodiscard]] hand::ActuatorVector limits(const hand::Description& hand,
                                            const hand::ActuatorVector& contact_torque) const;

 private:
  int ticks_ = 0;
  hand::ActuatorVector torques_;
};

/// Which fingers are done: they have met the object, or their command, which never leads the joint
/// by more than the torque limit allows, has stood still for a while. When all are, those that have
/// lost touch meanwhile close on; before, they would push the object ahead of them.
class FingersDone {
 public:
  explicit FingersDone(const hand::Description& hand);

  void update(const hand::HandReading& reading, const hand::HandCommand& command);

  /// Those that have met the object since they began to close.
  const hand::PerFinger<bool>& met() const { return met_; }
  bool done(std::size_t finger) const {
    return touches_[finger] || stuck_[finger] || (met_[finger] && !all_met_);
  }
  hand::PerFinger<bool> still_closing() const;
  /// It closes no further, whatever it touches.
  void stop(int finger) { stuck_[static_cast<std::size_t>(finger)] = true; }
  /// Whether all have been done for so long that none touches for a moment only, or have had the
  /// time for that.
  bool settled() const;

 private:
  bool all() const;

  std::vector<TouchDetector> detectors_;
  std::vector<int> drives_;  // the first actuator of each finger that closes; -1: none does
  hand::PerFinger<bool> touches_{}, met_{}, stuck_{};
  bool all_met_ = false;
  int settled_ = 0, since_all_met_ = 0;  // ticks
  hand::PerFinger<int> still_{}, apart_{};
  hand::PerFinger<double> last_{};
};

/// Notices which fingers press on something that they do not sense: they would push the object out
/// of the hand.
class UnsensedContacts {
 public:
  /// Keeps references.
  UnsensedContacts(const hand::Description& hand, const hand::ActuatorVector& contact_torque)
      : hand_(hand), contact_torque_(contact_torque) {}

  /// @return the fingers that have for a while
  std::vector<int> update(const hand::HandReading& reading, const hand::ActuatorVector& friction);

 private:
  [[nodiscard]] bool presses(const hand::HandReading& reading, const hand::ActuatorVector& friction,
                             int finger) const;

  const hand::Description& hand_;
  const hand::ActuatorVector& contact_torque_;
  hand::PerFinger<int> held_up_{};  // ticks
};

}  // namespace palpate::skills
