// SPDX-License-Identifier: Apache-2.0
#include "palpate/skills/executor.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <exception>
#include <limits>
#include <numbers>
#include <span>
#include <utility>

#include "palpate/core/error.hpp"
#include "palpate/hand/assembled_hand.hpp"
#include "palpate/hand/nearest_base.hpp"
#include "skills/command_gate.hpp"
#include "skills/reading_gate.hpp"
#include "skills/safe_posture.hpp"
#include "skills/unsensed_force.hpp"
#include "skills/watchdog.hpp"

namespace palpate::skills {
namespace {

constexpr double kLeverArm = 0.2;  // m: what a turn of 1 rad counts as a way of the hand
constexpr int kSteadyReadings = 10, kSteadyWindows = 10;  // that are averaged; at most
constexpr double kSteadyLoad = 0.15;                      // N between two windows
constexpr double kMaxDrift = 3;     // N that a sensor's error may have changed by; more is a load
constexpr int kCheckedSteps = 100;  // of a way that is asked about
constexpr int kEasingTicks = 30;    // in which a stopped hand gives way

/// Whether an attitude is stated in other turns than the command's: arms give angles from -pi to
/// pi.
bool is_turned_round(const hand::BasePosition& read, const hand::BasePosition& command) {
  return read.ypr.allFinite() &&
         (read.ypr - command.ypr).cwiseAbs().maxCoeff() > std::numbers::pi / 2;
}

/// s that the way takes at a speed (m/s).
double seconds_of(const hand::BasePosition& from, const hand::BasePosition& target, double speed) {
  const double turn = kLeverArm * (target.ypr - from.ypr).cwiseAbs().maxCoeff();
  return std::max((target.xyz - from.xyz).norm(), turn) / speed;
}

/// A tick after the other.
std::vector<hand::BasePosition> way_to(const hand::BasePosition& from,
                                       const hand::BasePosition& target,
                                       const SpeedProfile& profile) {
  std::vector<hand::BasePosition> way;
  for (int i = 1; i <= profile.ticks(); ++i) {
    way.push_back(between(from, target, profile.share(i)));
  }
  return way;
}

/// Whether the fingers have closed on the object, and not let go of it since.
bool holds_object(const estimation::EventLog& log) {
  using estimation::TouchEvent;
  bool holds = false;
  for (const auto& [event, reading] : log.moments) {
    if (estimation::is_grasp(event)) holds = true;
    if (event == TouchEvent::released || event == TouchEvent::opened ||
        event == TouchEvent::placed) {
      holds = false;
    }
  }
  return holds;
}

/// What a hand would read that stands where it is commanded and senses nothing.
hand::HandReading at_rest(const hand::Description& hand, const hand::HandCommand& command) {
  return {.joints = hand::joints_in_free_flexion(hand, command.positions),
          .torques = hand::ActuatorVector::Zero(hand.actuator_count()),
          .base = command.base,
          .contacts = std::vector<std::vector<hand::TipContact>>(hand.fingers.size()),
          .biotacs = {}};
}

}  // namespace

Executor::Executor(hand::Hand& hand, const hand::Description& model, const hand::HandCommand& start,
                   Observer observer, const ModelFactory* models, Safety safety)
    : hand_(hand),
      model_(model),
      command_(start),
      observer_(std::move(observer)),
      models_(models),
      deadline_(std::numeric_limits<double>::infinity()),
      safety_(std::move(safety)),
      exceptions_(std::uncaught_exceptions()),
      readings_(std::make_unique<ReadingGate>(model, safety_.options)),
      commands_(std::make_unique<CommandGate>(model.actuators, start, safety_.options)),
      unsensed_(std::make_unique<UnsensedForce>(model, safety_.options.unsensed_force)) {
  const double limit = safety_.options.watchdog;
  if (limit > 0) watchdog_ = std::make_unique<Watchdog>(safety_.stop_drives, limit);
  try {
    tick();
  } catch (const SafetyStop&) {  // every motion will say so
    if (log_.readings.empty()) log_.readings.push_back(at_rest(model, start));
  }
}

Executor::~Executor() {
  if (std::uncaught_exceptions() > exceptions_) {
    make_safe(Fault::exception, "an exception ended the robot's work");
  }
}

const ModelFactory& Executor::models() const {
  if (!models_)
    throw BadInput("this skill plans ahead, and the robot was given no models to plan with");
  return *models_;
}

void Executor::set_table(const Eigen::Isometry3d& T_world_table) {
  const double height = T_world_table.translation().z();
  table_height_ += height;
  command_.base.xyz.z() -= height;
  commands_->raise(-height);
  log_.T_world_table = Eigen::Isometry3d(T_world_table.linear());
}

Eigen::Vector3d Executor::steady_load() {
  Eigen::Vector3d before = Eigen::Vector3d::Constant(std::numeric_limits<double>::infinity());
  for (int i = 0; i < kSteadyWindows; ++i) {
    wait(kSteadyReadings * hand::kTick);
    Eigen::Vector3d now = Eigen::Vector3d::Zero();
    const auto count = std::min<std::size_t>(kSteadyReadings, log_.readings.size());
    for (const auto& reading : std::span(log_.readings).last(count)) {
      now += reading.base_force / static_cast<double>(count);
    }
    const bool steady = (now - before).norm() < kSteadyLoad;
    before = now;
    if (steady) break;
  }
  return before;
}

void Executor::tare() {
  const Eigen::Vector3d load = steady_load();
  if (time() >= deadline_ || load.norm() > kMaxDrift) return;
  load_error_.bias += reading().base.pose().linear().transpose() * load;
}

/// One step of the hand, in the world whose z = 0 is the table.
hand::HandReading Executor::step() {
  hand::HandCommand in_world = command_;
  in_world.base.xyz.z() += table_height_;
  const auto begin = std::chrono::steady_clock::now();
  pause_ = answered_ ? std::chrono::duration<double>(begin - *answered_).count() : 0;
  hand::HandReading reading = hand_.step(in_world);
  answered_ = std::chrono::steady_clock::now();
  if (is_turned_round(reading.base, in_world.base)) {
    reading.base = hand::nearest_base(reading.base.pose(), in_world.base);
  }
  reading.base.xyz.z() -= table_height_;
  sensed_load_ = reading.base_force;
  reading.base_force -= reading.base.pose().linear() * load_error_.bias;
  reading.base_force.z() -= load_error_.weight;
  return reading;
}

void Executor::add_event(estimation::TouchEvent event) {
  log_.moments.push_back({event, log_.readings.size() - 1});
  if (observer_.on_event) observer_.on_event(event);
}

void Executor::show(const localization::Posterior& posterior) const {
  if (observer_.on_posterior) observer_.on_posterior(posterior);
}

void Executor::tick() {
  require_running();
  if (safety_.stop.stop_requested()) stop_for(Fault::stop_requested, "a stop was requested");
  if (static_cast<double>(log_.readings.size()) * hand::kTick > safety_.options.max_log) {
    stop_for(Fault::log_full, fmt::format("{} readings are kept", log_.readings.size()));
  }
  if (grip_) grip_->law.advance(command_, reading(), grip_->max_torque, grip_->active);
  if (!log_.readings.empty()) limit_unsensed_force();
  try {
    command_ = commands_->limited(command_);
  } catch (const BadInput& error) {
    command_ = commands_->last();
    stop_for(Fault::invalid_command, error.what());
  }
  while (!read_once()) {
    if (safety_.stop.stop_requested()) stop_for(Fault::stop_requested, "a stop was requested");
  }
}

/// Fingers that something holds up without their sensing it press no further.
void Executor::limit_unsensed_force() {
  for (const int finger : unsensed_->limit(command_, commands_->last(), reading())) suspect(finger);
}

/// One step of the hand. @return whether it gave a reading that can be used
bool Executor::read_once() {
  hand::HandReading reading;
  try {
    const Watchdog::Guard guard(watchdog_.get());
    reading = step();
  } catch (const hand::LateAnswer& late) {
    stop_for(Fault::silent, late.what());
  } catch (const std::exception& error) {
    stop_for(Fault::exception, fmt::format("the hand: {}", error.what()));
  }
  if (watchdog_ && watchdog_->fired()) {
    stop_for(Fault::silent, fmt::format("a step took longer than {} s", safety_.options.watchdog));
  }
  const ReadingCheck check = readings_->check(reading, {sensed_load_, pause_}, command_);
  if (check.usable) keep(std::move(reading));
  if (check.fault != Fault::none) stop_for(check.fault, check.detail);
  return check.usable;
}

void Executor::keep(hand::HandReading reading) {
  log_.readings.push_back(std::move(reading));
  if (observer_.on_tick) observer_.on_tick(log_.readings.back(), command_);
}

void Executor::require_running() const {
  if (fault_) throw SafetyStop(fault_);
}

void Executor::stop_for(Fault fault, std::string detail) {
  make_safe(fault, std::move(detail));
  throw SafetyStop(fault_);
}

void Executor::make_safe(Fault fault, std::string detail) noexcept {
  if (fault_) return;
  fault_ = {fault, std::move(detail), log_.readings.empty() ? 0 : time()};
  grip_.reset();
  for (int i = 0; i < kEasingTicks && !log_.readings.empty(); ++i) {
    try {
      ease();
    } catch (...) {  // of the hand, or of who looks on: the next step may succeed
    }
  }
  try {
    if (safety_.stop_drives) safety_.stop_drives();
  } catch (...) {  // all has been tried
  }
}

/// One step more, with a reading, so that the base gives way to where it is, not to where it was.
/// What the fingers hold they keep, unless too much force is the fault.
void Executor::ease() {
  command_ = with_eased_base(command_, reading(), safety_.options);
  const bool forceful = fault_.fault == Fault::excess_force ||
                        fault_.fault == Fault::unsensed_load || fault_.fault == Fault::joint_stuck;
  if (forceful || !holds_object(log_)) {
    command_ = with_eased_fingers(command_, reading(), model_, safety_.options);
  }
  hand::HandReading now;
  {
    const Watchdog::Guard guard(watchdog_.get());
    now = step();
  }
  if (readings_->check(now, {sensed_load_, pause_}, command_).usable) keep(std::move(now));
}

void Executor::distrust(int finger, std::string detail) {
  if (trusted(finger)) survived_.push_back({Fault::touch_lost, std::move(detail), time()});
  readings_->distrust(finger);
}

bool Executor::suspected(int finger) const {
  return suspected_[static_cast<std::size_t>(finger)] && trusted(finger) && !cleared(finger);
}

std::vector<int> Executor::suspects() const {
  std::vector<int> fingers;
  for (int finger = 0; finger < model_.finger_count(); ++finger) {
    if (suspected(finger)) fingers.push_back(finger);
  }
  return fingers;
}

bool Executor::trusted(int finger) const { return readings_->trusted(finger); }
std::size_t Executor::limited_commands() const { return commands_->changed(); }

MotionEnd Executor::tick_until(const StopCondition& stop) {
  tick();
  if (time() >= deadline_) return MotionEnd::timed_out;
  return stop && stop(reading()) ? MotionEnd::stopped : MotionEnd::reached;
}

MotionEnd Executor::wait(double seconds, const StopCondition& stop) {
  for (int i = hand::whole_ticks(seconds); i > 0; --i) {
    if (const auto end = tick_until(stop); end != MotionEnd::reached) return end;
  }
  return MotionEnd::reached;
}

/// Of a way in the world whose z = 0 is the table.
hand::PathFeasibility Executor::check_path(std::vector<hand::BasePosition> way) const {
  for (hand::BasePosition& base : way) base.xyz.z() += table_height_;
  return hand_.check_path(way);
}

std::string Executor::obstacle(const hand::BasePosition& target) const {
  const double reach = target.xyz.norm(), workspace = safety_.options.workspace;
  if (reach > workspace) {
    return fmt::format("the mount would be {:.3f} m from the origin, {:.3f} m are allowed", reach,
                       workspace);
  }
  std::vector<hand::BasePosition> way;
  for (int i = 1; i <= kCheckedSteps; ++i) {
    way.push_back(between(command_.base, target, static_cast<double>(i) / kCheckedSteps));
  }
  return check_path(std::move(way)).obstacle;
}

MotionEnd Executor::move_base(const hand::BasePosition& target, double speed,
                              const StopCondition& stop) {
  if (stop) speed = std::min(speed, hand_.mount_limits().guarded_speed);
  const hand::BasePosition from = command_.base;
  SpeedProfile profile(seconds_of(from, target, speed));
  limit_base(target, profile);
  const hand::PathFeasibility checked = check_path(way_to(from, target, profile));
  // A guarded move goes as far as it can: what it is to meet may end it before.
  const bool whole = checked.obstacle.empty();
  if (!whole && (!stop || checked.feasible == 0)) throw Unreachable(checked.obstacle);
  const double last = whole ? 1 : profile.share(static_cast<int>(checked.feasible));
  profile.stretch(checked.stretch);
  for (int i = 1; i <= profile.ticks() && (whole || profile.share(i) <= last); ++i) {
    command_.base = between(from, target, profile.share(i));
    if (const auto end = tick_until(stop); end != MotionEnd::reached) return end;
  }
  if (!whole) throw Unreachable(checked.obstacle);
  return MotionEnd::reached;
}

MotionEnd Executor::follow(std::span<const hand::HandCommand> way, const StopCondition& stop) {
  std::vector<hand::BasePosition> bases;
  for (const auto& command : way) bases.push_back(command.base);
  const hand::PathFeasibility checked = check_path(std::move(bases));
  if (!checked.obstacle.empty()) throw Unreachable(checked.obstacle);
  for (const auto& command : way) {
    command_ = command;
    if (const auto end = tick_until(stop); end != MotionEnd::reached) return end;
  }
  return MotionEnd::reached;
}

MotionEnd Executor::move_fingers(const hand::ActuatorVector& posture, double seconds) {
  SpeedProfile profile(seconds);
  limit_fingers(posture, profile);
  const hand::ActuatorVector from = command_.positions;
  for (int i = 1; i <= profile.ticks(); ++i) {
    command_.positions = from + profile.share(i) * (posture - from);
    if (const auto end = tick_until({}); end != MotionEnd::reached) return end;
  }
  return MotionEnd::reached;
}

MotionEnd Executor::move_hand(const hand::HandCommand& target, double speed, double seconds) {
  const hand::HandCommand from = command_;
  SpeedProfile profile(std::max(seconds, seconds_of(from.base, target.base, speed)));
  limit_base(target.base, profile);
  limit_fingers(target.positions, profile);
  const hand::PathFeasibility checked = check_path(way_to(from.base, target.base, profile));
  if (!checked.obstacle.empty()) throw Unreachable(checked.obstacle);
  profile.stretch(checked.stretch);
  for (int i = 1; i <= profile.ticks(); ++i) {
    command_.base = between(from.base, target.base, profile.share(i));
    command_.positions = from.positions + profile.share(i) * (target.positions - from.positions);
    if (const auto end = tick_until({}); end != MotionEnd::reached) return end;
  }
  return MotionEnd::reached;
}

void Executor::limit_base(const hand::BasePosition& target, SpeedProfile& profile) const {
  const SafetyOptions& limits = safety_.options;
  const hand::MountLimits gentle = hand_.mount_limits();
  profile.limit((target.xyz - command_.base.xyz).norm(), limits.base_speed,
                std::min(limits.base_acceleration, gentle.acceleration));
  profile.limit((target.ypr - command_.base.ypr).norm(), limits.turn_speed,
                std::min(limits.turn_acceleration, gentle.turn_acceleration));
}

void Executor::limit_fingers(const hand::ActuatorVector& posture, SpeedProfile& profile) {
  const hand::ActuatorVector& from = command_.positions;
  if (posture.size() != from.size()) {
    stop_for(Fault::invalid_command, fmt::format("a posture of {} actuators, the hand has {}",
                                                 posture.size(), from.size()));
  }
  profile.limit((posture - from).cwiseAbs().maxCoeff(), safety_.options.finger_speed,
                safety_.options.finger_acceleration);
}

}  // namespace palpate::skills
