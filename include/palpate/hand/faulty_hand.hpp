// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <deque>
#include <functional>
#include <limits>
#include <optional>
#include <string_view>

#include "palpate/core/random.hpp"
#include "palpate/hand/hand.hpp"

namespace palpate::hand {

/// What goes wrong with a hand.
enum class InjectedFault {
  none,
  load_nan,          ///< the mount's load is not finite
  load_zero,         ///< it reads zero
  load_frozen,       ///< it stays at its last value
  joint_nan,         ///< one joint's angle is not finite
  joint_stuck,       ///< one actuator no longer moves
  torques_zero,      ///< the actuators' torques read zero
  contacts_nan,      ///< of all fingertips
  contacts_none,     ///< no fingertip senses anything
  finger_silent,     ///< one fingertip senses nothing
  finger_stuck,      ///< one fingertip repeats its last contacts
  finger_nan,        ///< one fingertip's contacts are not finite
  finger_saturated,  ///< one fingertip senses the most its sensor can read, always
  fingers_swapped,   ///< two fingertips' contacts are exchanged
  taxel_dead,        ///< one fingertip senses nothing near one spot
  false_contacts,    ///< a tenth of the time a fingertip senses what is not there
  readings_stuck,    ///< all but the time stays at its last value
  link_dead,         ///< the last reading is repeated, time included
  link_gap,          ///< so it is for 0.2 s, and then not
  time_nan,
  time_jitter,    ///< time stamps are off by 3 ms, as are real ones
  delay,          ///< readings are 0.2 s late
  throws,         ///< step() throws
  mount_stuck,    ///< the mount no longer moves
  object_pushed,  ///< something pushes the object 10 mm aside, whatever holds it
  second_object,  ///< another object stands beside it, from the first
};
inline constexpr std::array<std::string_view, 26> kInjectedFaultNames = {
    "none",           "load_nan",       "load_zero",        "load_frozen",     "joint_nan",
    "joint_stuck",    "torques_zero",   "contacts_nan",     "contacts_none",   "finger_silent",
    "finger_stuck",   "finger_nan",     "finger_saturated", "fingers_swapped", "taxel_dead",
    "false_contacts", "readings_stuck", "link_dead",        "link_gap",        "time_nan",
    "time_jitter",    "delay",          "throws",           "mount_stuck",     "object_pushed",
    "second_object"};

std::string_view to_string(InjectedFault fault);
/// @throws BadInput for a name that is none of kInjectedFaultNames
InjectedFault injected_fault(std::string_view name);

/// What goes wrong, and when.
struct FaultSchedule {
  InjectedFault fault = InjectedFault::none;
  double from = 0;                                          ///< s of the hand's time
  double length = std::numeric_limits<double>::infinity();  ///< s, after which all is well again
  int finger = 1;          ///< of faults of one fingertip, an index into Description::fingers
  int joint = 5;           ///< of joint_nan, an index into Description::joints
  int actuator = 9;        ///< of joint_stuck, an index into Description::actuators
  std::uint64_t seed = 0;  ///< of false_contacts and time_jitter
};

/// Another hand with a fault: what it reads, or does, is spoilt from a time on.
///
/// For tests and campaigns. It also measures what the other hand truly bore, whatever it reported.
class FaultyHand : public Hand {
 public:
  /// @param hand  must outlive this
  /// @param on_onset  called when the fault sets in: faults of what is around the hand are not its
  FaultyHand(Hand& hand, const FaultSchedule& schedule, std::function<void()> on_onset = {});

  /// @throws BadInput when a fault sets in of a finger, joint or actuator that the hand has not
  HandReading step(const HandCommand& command) override;
  std::optional<HandReading> sense() override;
  [[nodiscard]] PathFeasibility check_path(std::span<const MountPosition> way) const override {
    return hand_.check_path(way);
  }
  [[nodiscard]] MountLimits mount_limits() const override { return hand_.mount_limits(); }
  [[nodiscard]] ArmPosture arm_posture() const override { return hand_.arm_posture(); }

  /// Largest load of the mount so far, N.
  double peak_load() const { return peak_load_; }
  /// Largest normal force of a fingertip so far, N.
  double peak_tip_force() const { return peak_tip_force_; }
  /// When the fault set in, by the other hand's clock; nothing if it has not.
  std::optional<double> began() const { return began_; }

 private:
  HandReading spoilt(const HandReading& reading);
  void measure(const HandReading& reading);
  HandCommand obeyed(const HandCommand& command);
  void begin_with_nothing(const HandReading& reading);
  HandReading falsified(const HandReading& reading);
  void spoil_load(HandReading& reading) const;
  void spoil_contacts(HandReading& reading);
  void spoil_finger(std::vector<TipContact>& contacts);
  HandReading spoil_link(const HandReading& reading);

  void set_in(const HandReading& reading);

  Hand& hand_;
  FaultSchedule schedule_;
  std::function<void()> on_onset_;
  RandomStream random_;
  HandReading before_;  ///< last reading before the fault
  std::deque<HandReading> queue_;
  std::optional<double> began_;
  bool ended_ = false;
  std::optional<HandCommand> stuck_at_;   ///< the command of what does not move
  std::optional<Eigen::Vector3d> taxel_;  ///< that is dead, in the distal link's frame
  double peak_load_ = 0, peak_tip_force_ = 0;
};

}  // namespace palpate::hand
