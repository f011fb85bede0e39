// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "palpate/hand/hand.hpp"
#include "skills/touch_detector.hpp"

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
  /// @param closing  the fingers that close; the others are done
  FingersDone(const hand::Description& hand, const hand::PerFinger<bool>& closing);

  void update(const hand::HandReading& reading, const hand::HandCommand& command);

  /// Those that have met the object since they began to close.
  const hand::PerFinger<bool>& met() const { return met_; }
  bool done(std::size_t finger) const {
    return touches_[finger] || stuck_[finger] || (met_[finger] && !all_met_);
  }
  hand::PerFinger<bool> still_closing() const;
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

/// Notices that the thumb presses on something that it does not sense. Fingers beside it may be
/// replaced by their neighbours; a thumb pushes the object out of the hand.
class UnsensedThumbContact {
 public:
  /// Keeps references.
  UnsensedThumbContact(const hand::Description& hand, const hand::ActuatorVector& contact_torque);

  /// @return whether it has for a while
  bool update(const hand::HandReading& reading, const hand::ActuatorVector& friction);

 private:
  const hand::Description& hand_;
  const hand::ActuatorVector& contact_torque_;
  std::vector<int> drives_;
  int held_up_ = 0;
};

}  // namespace palpate::skills
