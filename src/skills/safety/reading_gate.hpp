// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <optional>
#include <string>

#include "palpate/hand/hand.hpp"
#include "palpate/skills/finger_trust.hpp"
#include "palpate/skills/safety.hpp"
#include "skills/safety/flicker_filter.hpp"

namespace palpate::skills {

/// What is to be done with a reading.
struct ReadingCheck {
  bool usable = true;         ///< else the hand stands still for this tick
  Fault fault = Fault::none;  ///< for which the robot must stop
  std::string detail;         ///< of the fault
};

/// What is known of a hand's step beside its reading.
struct StepReport {
  /// N of the mount, as its sensor gave it: in the reading it is corrected by an attitude that is
  /// not the same in any two of them.
  Eigen::Vector3d sensed_load = Eigen::Vector3d::Zero();
  double pause = 0;       ///< s before the step in which none was made
  bool commanded = true;  ///< else it is sensed before any command
  FingerTrust trust;      ///< in what the fingertips sense
};

/// Watches what a hand reads, one reading a tick. Its clock is the number of ticks.
class ReadingGate {
 public:
  ReadingGate(const hand::Description& hand, const SafetyOptions& options);

  /// Takes the contacts of fingertips that cannot be believed, or are not, out of the reading.
  /// @param command  that was given for the tick
  ReadingCheck check(hand::HandReading& reading, const StepReport& step,
                     const hand::HandCommand& command);

 private:
  ReadingCheck check_time(double time, double pause);
  [[nodiscard]] std::string late_by(double age, double now, double time) const;
  ReadingCheck check_values(const hand::HandReading& reading);
  [[nodiscard]] std::string not_finite(const hand::HandReading& reading) const;
  [[nodiscard]] std::string wrong_size(const hand::HandReading& reading) const;
  [[nodiscard]] std::string impossible_value(const hand::HandReading& reading, Fault& fault) const;
  [[nodiscard]] std::string jump(const hand::HandReading& reading) const;
  ReadingCheck check_repeats(const hand::HandReading& reading, const Eigen::Vector3d& sensed_load);
  ReadingCheck check_touch(hand::HandReading& reading, const FingerTrust& trust);
  ReadingCheck check_load(const hand::HandReading& reading);
  [[nodiscard]] bool presses(const hand::HandReading& reading, int actuator) const;
  [[nodiscard]] const char* astray(int still, int off) const;
  [[nodiscard]] ReadingCheck check_start(const hand::HandReading& reading,
                                         const hand::HandCommand& command, bool commanded) const;
  ReadingCheck check_tracking(const hand::HandReading& reading, const hand::HandCommand& command);
  ReadingCheck check_mount(const hand::HandReading& reading, const hand::HandCommand& command);

  hand::Description hand_;
  SafetyOptions options_;
  std::optional<hand::HandReading> last_;                // that was usable
  Eigen::Vector3d last_load_ = Eigen::Vector3d::Zero();  // that was sensed with it
  long tick_ = 0, last_tick_ = 0;  // of this reading, and of the last usable one
  double lead_ = 0;                // s of the ticks before the hand's clock
  double first_time_ = 0;          // s of the hand's clock, of the first reading
  double first_now_ = 0;           // s of the ticks, of the same
  int bad_ = 0;                    // readings in a row that hold impossible values
  int same_joints_ = 0, same_torques_ = 0, same_load_ = 0;  // readings that repeat the one before
  int touchless_ = 0;  // readings in a row without a fingertip that can be believed
  hand::PerFinger<int> same_contacts_{};
  hand::PerFinger<std::vector<hand::TipContact>> last_contacts_;
  FlickerFilter flicker_;
  hand::ActuatorVector rest_positions_;  // where a joint has stood
  hand::ActuatorVector
      allowed_errors_;       // rad: soft actuators lag behind with the force they may use
  std::vector<int> astray_;  // ticks for which it has, off its command
  std::vector<int> off_;     // ticks for which it has been off its command, standing or not
  Eigen::Vector3d mount_rest_ = Eigen::Vector3d::Zero();
  int mount_astray_ = 0, mount_off_ = 0;
};

}  // namespace palpate::skills
