// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

#include "palpate/estimation/event_log.hpp"
#include "palpate/grasping/closing_law.hpp"
#include "palpate/hand/hand.hpp"
#include "palpate/hand/kinematics.hpp"
#include "palpate/localization/posterior.hpp"
#include "palpate/planning/arm_planner.hpp"
#include "palpate/skills/finger_trust.hpp"
#include "palpate/skills/forward_model.hpp"
#include "palpate/skills/load_sensor.hpp"
#include "palpate/skills/safety.hpp"

namespace palpate::skills {

class ReadingGate;
struct ReadingCheck;
class CommandGate;
class SpeedProfile;
class UnsensedForce;
class Watchdog;

/// How a motion ended.
enum class MotionEnd { reached, stopped, timed_out };

/// What the fingers do while the mount moves: close with limited torque.
struct Grip {
  grasping::ClosingLaw law;
  hand::ActuatorVector max_torque;  ///< N m
  hand::PerFinger<bool> active;
};

/// What carries the hand cannot take it along a motion's way. Thrown before the motion begins; a
/// phase that it ends has failed, and says so.
class Unreachable : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Straight lines along which the mount can be brought to some positions, one after the other.
struct MountPath {
  std::vector<hand::MountPosition> corners;  ///< their ends, with those positions
  std::string obstacle;                      ///< why there is no such way; empty: there is one
};

/// Moves a hand tick by tick and keeps all that it sensed. It knows nothing but the hand's
/// readings.
///
/// Every reading and every command passes a gate (SafetyOptions). While readings are missing or
/// impossible the hand stands still and nothing is kept of them; a fault stops the robot for good:
/// the mount gives way to what it pushes, the fingers ease to a light hold, and SafetyStop is
/// thrown, now and at every later tick. The same happens where an exception passes through a phase
/// or ends the robot's life.
class Executor {
 public:
  using StopCondition = std::function<bool(const hand::HandReading&)>;

  /// Who wants to know what the robot does; each may be empty.
  struct Observer {
    std::function<void(const hand::HandReading&, const hand::HandCommand&)> on_tick;
    std::function<void(estimation::TouchEvent)> on_event;
    std::function<void(const localization::Posterior&)> on_posterior;  ///< of the resting object
  };

  /// @param start  where the hand is commanded now, and is: one that is elsewhere is stopped where
  ///   it stands (not_at_start), before any command if it can tell (Hand::sense)
  /// @param models  of the world, for the skills that plan; must outlive the robot
  ///
  /// A fault of the hand's first reading is thrown by the first motion.
  /// @throws BadInput unless `start` has one position an actuator
  Executor(hand::Hand& hand, const hand::Description& model, const hand::HandCommand& start,
           Observer observer = {}, const ModelFactory* models = nullptr, Safety safety = {});
  ~Executor();
  Executor(const Executor&) = delete;
  Executor& operator=(const Executor&) = delete;

  const hand::Description& model() const { return model_; }
  /// The hand is known better now.
  void set_model(const hand::Description& model) { model_ = model; }
  /// The table has been found here: from now on all is commanded and read in a world whose z = 0 is
  /// the table at the origin; its tilt is in the log.
  void set_table(const Eigen::Isometry3d& T_world_table);
  /// Readings are corrected by what it knows.
  LoadSensor& load_sensor() { return load_sensor_; }
  /// What skills plan with. @throws BadInput if the robot was given none
  const ModelFactory& models() const;
  const hand::HandCommand& command() const { return command_; }
  const hand::HandReading& reading() const { return log_.readings.back(); }
  const estimation::EventLog& log() const { return log_; }
  const std::vector<hand::Actuator>& actuators() const { return model_.actuators; }
  double time() const { return log_.readings.back().time; }

  /// What has stopped the robot, if anything has.
  const FaultReport& fault() const { return fault_; }
  /// Stops the robot for good, unless it has stopped before: mount and fingers ease, see above.
  void make_safe(Fault fault, std::string detail) noexcept;
  /// make_safe(), and then @throws SafetyStop.
  [[noreturn]] void stop_for(Fault fault, std::string detail);
  /// @throws SafetyStop if the robot has stopped, or the hand has thrown in judging a way
  void require_running();

  /// From now on nothing is believed of what this fingertip senses: its contacts are dropped. A
  /// fault with which the robot goes on (touch_lost).
  /// @param detail  one line that names the finger and says why
  void distrust(int finger, std::string detail);
  /// From now on the contacts that either fingertip reports are taken for the other's. A fault with
  /// which the robot goes on (touch_swapped).
  void swap_touch(int finger, int other);
  FingerTrust& trust() { return trust_; }
  const FingerTrust& trust() const { return trust_; }
  /// Faults with which the robot went on.
  const std::vector<FaultReport>& survived() const { return survived_; }

  const SafetyOptions& limits() const { return safety_.options; }
  /// Commands that a limit has changed, so far. Skills ask for none that needs it.
  std::size_t limited_commands() const;

  /// Motions end with timed_out once this time (s) has come.
  void set_deadline(double time) { deadline_ = time; }

  /// Records an event at the present reading, for the estimator.
  void add_event(estimation::TouchEvent event);

  /// Shows the observer where the resting object may be, by the touches so far; in the world.
  void show(const localization::Posterior& posterior) const;

  /// From now on every tick advances this grip; nothing releases it.
  void set_grip(std::optional<Grip> grip) { grip_ = std::move(grip); }

  /// Stays for `seconds`, or until `stop`.
  MotionEnd wait(double seconds, const StopCondition& stop = {});

  /// Why the mount cannot be brought there from where it is commanded to be, on a straight line;
  /// empty: it can. What the hand throws in judging is a fault of the next tick
  /// (require_running()).
  [[nodiscard]] std::string obstacle(const hand::MountPosition& target) const;

  /// How the mount can be brought to targets from where it is commanded to be. Where an arm cannot
  /// take it to the first one on a straight line, it turns first and then moves, or the other way
  /// round. What the hand throws in judging is as of obstacle().
  [[nodiscard]] MountPath path_to(std::vector<hand::MountPosition> targets) const;

  /// The arm that carries the hand, as commanded; nothing where the hand does not tell it. What the
  /// hand throws is as of obstacle().
  [[nodiscard]] std::optional<planning::ArmStart> arm_start() const;

  /// Moves the mount on a straight line (m/s; it turns along in proportion), until there or `stop`;
  /// without `stop` along path_to().
  /// Where the arm's joints are slower than that, it takes longer. A speed that is not positive and
  /// finite, or that takes longer than the log, is a fault (invalid_command). @throws Unreachable
  MotionEnd move_mount(const hand::MountPosition& target, double speed,
                       const StopCondition& stop = {});

  /// Gives one command a tick, until the last or `stop`. Where the arm's joints are slower than
  /// that, it takes longer, along the lines between the commands. @throws Unreachable
  MotionEnd follow(std::span<const hand::HandCommand> way, const StopCondition& stop = {});

  /// Moves all actuators to a posture in a given time.
  MotionEnd move_fingers(const hand::ActuatorVector& posture, double seconds);

  /// Both at once, each in proportion to the other: the mount as move_mount() does, through the
  /// air, the fingers in no less than `seconds`. @throws Unreachable
  MotionEnd move_hand(const hand::HandCommand& target, double speed, double seconds);

 private:
  void look();
  void tick();
  void limit_unsensed_force();
  MotionEnd tick_until(const StopCondition& stop);
  bool read_once();
  void hear(const std::function<void()>& ask);
  bool take(hand::HandReading reading);
  ReadingCheck check_reading(hand::HandReading& reading);
  void keep(hand::HandReading reading);
  hand::HandReading step();
  hand::HandReading in_table_world(hand::HandReading reading);
  void ease();
  [[nodiscard]] hand::HandCommand where_it_is() const;
  template <class Value>
  Value ask_hand(const std::function<Value()>& ask) const;
  [[nodiscard]] hand::PathFeasibility check_path(std::vector<hand::MountPosition> way) const;
  [[nodiscard]] hand::MountLimits mount_limits() const;
  [[nodiscard]] std::string obstacle_along(const std::vector<hand::MountPosition>& corners) const;
  MotionEnd move_straight(const hand::MountPosition& target, double speed,
                          const StopCondition& stop);
  void require_motion(const hand::MountPosition& target, double speed);
  void limit_mount(const hand::MountPosition& target, SpeedProfile& profile) const;
  void limit_fingers(const hand::ActuatorVector& posture, SpeedProfile& profile);

  hand::Hand& hand_;
  hand::Description model_;
  hand::HandCommand command_;
  Observer observer_;
  const ModelFactory* models_;
  estimation::EventLog log_;
  double table_height_ = 0;  ///< m, of the table in the world of the hand's commands
  LoadSensor load_sensor_;
  std::optional<std::chrono::steady_clock::time_point> answered_;  ///< the last step
  bool commanded_ = false;  ///< the hand has been given a command
  double pause_ = 0;        ///< s before the last step in which none was made: a skill was thinking
  std::optional<Grip> grip_;
  double deadline_;
  Safety safety_;
  FaultReport fault_;
  std::vector<FaultReport> survived_;
  FingerTrust trust_;
  mutable std::optional<std::string> hand_failure_;  ///< of a question to it, not yet a fault
  int exceptions_;                                   ///< under way when the robot was made
  std::unique_ptr<ReadingGate> readings_;
  std::unique_ptr<CommandGate> commands_;
  std::unique_ptr<UnsensedForce> unsensed_;
  std::unique_ptr<Watchdog> watchdog_;  ///< none for a simulated hand
};

}  // namespace palpate::skills
