// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <functional>
#include <stdexcept>
#include <stop_token>
#include <string>
#include <string_view>

namespace palpate::skills {

/// Why a robot was stopped.
enum class Fault {
  none,
  stop_requested,      ///< by the user, or from another thread
  not_finite,          ///< a reading holds a value that is not finite
  out_of_range,        ///< a joint, the mount or the load reads what cannot be
  implausible_change,  ///< a joint or the mount has jumped between two readings
  frozen,              ///< joints, torques or load repeat themselves bit for bit
  late,                ///< readings come, but are too old
  silent,              ///< readings have stopped
  excess_force,        ///< the mount bears more than it may
  unsensed_load,       ///< so it does, and no fingertip senses anything
  joint_stuck,         ///< a joint does not follow its command
  touch_lost,          ///< no fingertip's sensor can be used
  invalid_command,     ///< a command holds a value that is not finite, or a speed that is none
  log_full,            ///< the log has reached its limit
  exception,           ///< the hand, a skill or the user's code threw
  not_at_start,        ///< the first reading is not of where the hand is said to stand
  touch_swapped,       ///< two fingertips report each other's contacts
};
inline constexpr std::array<std::string_view, 17> kFaultNames = {
    "none",         "stop_requested", "not_finite",      "out_of_range", "implausible_change",
    "frozen",       "late",           "silent",          "excess_force", "unsensed_load",
    "joint_stuck",  "touch_lost",     "invalid_command", "log_full",     "exception",
    "not_at_start", "touch_swapped"};

inline std::string_view to_string(Fault fault) {
  return kFaultNames[static_cast<std::size_t>(fault)];
}

/// What stopped a robot, and when.
struct FaultReport {
  Fault fault = Fault::none;
  std::string detail;  ///< one line with the values
  double time = 0;     ///< s of the robot's time, of the last reading that was good
  explicit operator bool() const { return fault != Fault::none; }
};

/// Thrown by an Executor that has stopped its hand. pick(), place(), regrasp() and pick_and_place()
/// catch it and report the fault in their results.
class SafetyStop : public std::runtime_error {
 public:
  explicit SafetyStop(FaultReport report)
      : std::runtime_error(std::string(to_string(report.fault)) + ": " + report.detail),
        report_(std::move(report)) {}
  [[nodiscard]] const FaultReport& report() const { return report_; }

 private:
  FaultReport report_;
};

/// What an Executor accepts as a reading, and what it lets a command be.
struct SafetyOptions {
  double max_age = 0.05;           ///< s that a reading may be late, by the executor's own ticks
  double max_gap = 0.25;           ///< s without a fresh reading, in which the hand stands still
  int max_bad = 4;                 ///< readings in a row that are not finite, or out of range
  int max_repeats = 4;             ///< readings in a row that repeat joints, torques or load
  double max_load = 40;            ///< N, of the mount
  double load_range = 250;         ///< N that the mount's sensor can read
  double tip_force_range = 50;     ///< N that a fingertip's sensor can read
  double tip_reach = 0.1;          ///< m from a fingertip's surface, of contacts that are believed
  double workspace = 1.5;          ///< m of the mount from the origin
  double joint_margin = 0.4;       ///< rad that a joint may read beyond its range
  double joint_jump = 0.5;         ///< rad between two readings
  double mount_jump = 0.05;        ///< m between two readings
  double tracking_error = 0.6;     ///< rad by which a joint that stands still may miss its command
  double tracking_time = 0.5;      ///< s that it may
  double mount_error = 0.05;       ///< m by which a mount that stands still may miss its command
  double mount_speed = 0.6;        ///< m/s
  double mount_acceleration = 10;  ///< m/s^2
  double turn_speed = 3.0;         ///< rad/s, of the mount
  double turn_acceleration = 50;   ///< rad/s^2, of the mount
  double finger_speed = 4.0;       ///< rad/s
  double finger_acceleration = 200;  ///< rad/s^2
  double unsensed_force = 6;    ///< N, about, with which a finger that senses no contact may press
  double release_speed = 0.25;  ///< m/s at which a stopped mount gives way to what it pushes
  double rest_torque = 0.1;     ///< N m with which a stopped finger holds on at most
  double watchdog = 0;          ///< s of wall time that a step may take; 0: simulated, no limit
  double max_log = 3600;        ///< s of readings that are kept

  template <class Visitor>
  void visit(Visitor&& v) {
    v.expert("max_age", max_age, 0.01, 10.0, "s, age above which a reading is rejected as late");
    v.expert("max_gap", max_gap, 0.01, 10.0,
             "s without a valid reading, during which the hand stands still, before the robot is "
             "stopped");
    v.expert("max_bad", max_bad, 1, 1000,
             "number of readings in a row that may be not finite or out of range");
    v.expert("max_repeats", max_repeats, 2, 100000,
             "number of readings in a row that may repeat one another");
    v("max_load", max_load, 1.0, 1e4, "N, largest load on the mount");
    v.expert("load_range", load_range, 1.0, 1e5, "N, measuring range of the mount's force sensor");
    v.expert("tip_force_range", tip_force_range, 0.1, 1e4,
             "N, measuring range of a fingertip's force sensor");
    v.expert("tip_reach", tip_reach, 0.01, 10.0,
             "m, largest distance of a contact from its fingertip's surface");
    v.expert("workspace", workspace, 0.1, 100.0,
             "m, largest distance of the mount from the origin");
    v.expert("joint_margin", joint_margin, 0.0, 10.0,
             "rad, by which a joint's reading may be outside its range");
    v.expert("joint_jump", joint_jump, 0.01, 10.0,
             "rad, largest change of a joint between two readings");
    v.expert("mount_jump", mount_jump, 0.001, 10.0,
             "m, largest motion of the mount between two readings");
    v.expert("tracking_error", tracking_error, 0.01, 10.0, "rad, largest error of a joint at rest");
    v.expert("tracking_time", tracking_time, 0.01, 100.0,
             "s, for which a joint or the mount may exceed its tracking error");
    v.expert("mount_error", mount_error, 0.001, 10.0, "m, largest error of a mount at rest");
    v("mount_speed", mount_speed, 0.01, 10.0, "m/s, largest commanded speed of the mount");
    v.expert("mount_acceleration", mount_acceleration, 0.1, 1000.0,
             "m/s^2, largest commanded acceleration of the mount");
    v.expert("turn_speed", turn_speed, 0.01, 50.0,
             "rad/s, largest commanded angular speed of the mount");
    v.expert("turn_acceleration", turn_acceleration, 0.1, 5000.0,
             "rad/s^2, largest commanded angular acceleration of the mount");
    v("finger_speed", finger_speed, 0.01, 50.0, "rad/s, largest commanded speed of a finger joint");
    v.expert("finger_acceleration", finger_acceleration, 0.1, 5000.0,
             "rad/s^2, largest commanded acceleration of a finger joint");
    v.expert("unsensed_force", unsensed_force, 0.1, 1e4,
             "N, approximate force with which a finger that senses no contact may press");
    v.expert("release_speed", release_speed, 0.01, 10.0,
             "m/s, speed at which a stopped mount yields");
    v.expert("rest_torque", rest_torque, 0.0, 5.0,
             "N m, largest torque with which a stopped finger holds");
    v("watchdog", watchdog, 0.0, 10.0, "s of wall time, limit of a step; 0: no limit");
    v.expert("max_log", max_log, 1.0, 1e6, "s, length of the readings that are kept");
  }
};

/// How a robot is watched, and how it can be stopped from outside.
struct Safety {
  SafetyOptions options;
  std::stop_token stop;  ///< a request, from any thread, stops the robot within a tick
  /// Stops the drives by whatever means there are beside the hand's step(), which must then return.
  /// Called at every fault, by the watchdog from a thread of its own while step() is under way, but
  /// never twice at once; what it throws is ignored. A simulated hand, whose time stands still
  /// between steps, needs none.
  std::function<void()> stop_drives = {};
};

}  // namespace palpate::skills
