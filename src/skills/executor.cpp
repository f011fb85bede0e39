// SPDX-License-Identifier: Apache-2.0
#include "palpate/skills/executor.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <exception>
#include <limits>
#include <memory>
#include <mutex>
#include <numbers>
#include <ranges>
#include <utility>

#include "palpate/core/error.hpp"
#include "palpate/hand/assembled_hand.hpp"
#include "palpate/hand/nearest_mount.hpp"
#include "skills/safety/command_gate.hpp"
#include "skills/safety/reading_gate.hpp"
#include "skills/safety/safe_posture.hpp"
#include "skills/safety/unsensed_force.hpp"
#include "skills/safety/watchdog.hpp"

namespace palpate::skills {
namespace {

constexpr int kEasingTicks = 30;  // in which a stopped hand gives way

/// Whether an attitude is stated in other turns than the command's: arms give angles from -pi to
/// pi.
bool is_turned_round(const hand::MountPosition& read, const hand::MountPosition& command) {
  return read.ypr.allFinite() &&
         (read.ypr - command.ypr).cwiseAbs().maxCoeff() > std::numbers::pi / 2;
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

/// One call at a time: the watchdog has a thread of its own.
std::function<void()> one_at_a_time(std::function<void()> call) {
  if (!call) return call;
  return [call = std::move(call), mutex = std::make_shared<std::mutex>()] {
    const std::lock_guard lock(*mutex);
    call();
  };
}

/// What a hand would read that stands where it is commanded and senses nothing.
hand::HandReading at_rest(const hand::Description& hand, const hand::HandCommand& command) {
  return {.joints = hand::joints_in_free_flexion(hand, command.positions),
          .torques = hand::ActuatorVector::Zero(hand.actuator_count()),
          .mount = command.mount,
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
  safety_.stop_drives = one_at_a_time(std::move(safety_.stop_drives));
  const double limit = safety_.options.watchdog;
  if (limit > 0) watchdog_ = std::make_unique<Watchdog>(safety_.stop_drives, limit);
  try {
    look();
    tick();
  } catch (const SafetyStop&) {  // every motion will say so
    if (log_.readings.empty()) log_.readings.push_back(at_rest(model, start));
  } catch (...) {  // of who looks on: there will be no destructor
    make_safe(Fault::exception, "an exception ended the robot's first step");
    throw;
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
  command_.mount.xyz.z() -= height;
  commands_->raise(-height);
  log_.T_world_table = Eigen::Isometry3d(T_world_table.linear());
}

/// What the hand senses before it is commanded anything, if it can tell.
void Executor::look() {
  for (bool known = false; !known;) {
    if (safety_.stop.stop_requested()) stop_for(Fault::stop_requested, "a stop was requested");
    std::optional<hand::HandReading> sensed;
    hear([&] { sensed = hand_.sense(); });
    if (!sensed) return;
    answered_ = std::chrono::steady_clock::now();
    known = take(in_table_world(*std::move(sensed)));
  }
}

/// One step of the hand, in the world whose z = 0 is the table.
hand::HandReading Executor::step() {
  hand::HandCommand in_world = command_;
  in_world.mount.xyz.z() += table_height_;
  const auto begin = std::chrono::steady_clock::now();
  pause_ = answered_ ? std::chrono::duration<double>(begin - *answered_).count() : 0;
  commanded_ = true;
  hand::HandReading reading = hand_.step(in_world);
  answered_ = std::chrono::steady_clock::now();
  return in_table_world(std::move(reading));
}

/// A reading in the world whose z = 0 is the table, less what is known of the load's error, and
/// with every contact at the fingertip that senses it.
hand::HandReading Executor::in_table_world(hand::HandReading reading) {
  reading.mount.xyz.z() -= table_height_;
  if (is_turned_round(reading.mount, command_.mount)) {
    reading.mount = hand::nearest_mount(reading.mount.pose(), command_.mount);
  }
  load_sensor_.correct(reading);
  trust_.assign_contacts(reading);
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
  for (const int finger : unsensed_->limit(command_, commands_->last(), reading())) {
    trust_.suspect(finger);
  }
}

/// One step of the hand. @return whether it gave a reading that can be used
bool Executor::read_once() {
  hand::HandReading reading;
  hear([&] {
    const Watchdog::Guard guard(watchdog_.get());
    reading = step();
  });
  if (watchdog_ && watchdog_->fired()) {
    stop_for(Fault::silent, fmt::format("a step took longer than {} s", safety_.options.watchdog));
  }
  return take(std::move(reading));
}

/// Asks the hand for a reading. What it throws stops the robot.
void Executor::hear(const std::function<void()>& ask) {
  try {
    ask();
  } catch (const hand::LateAnswer& late) {
    stop_for(Fault::silent, late.what());
  } catch (const std::exception& error) {
    stop_for(Fault::exception, fmt::format("the hand: {}", error.what()));
  } catch (...) {
    stop_for(Fault::exception, "the hand: an unknown exception");
  }
}

/// Keeps a reading if it can be used. @return whether it can
bool Executor::take(hand::HandReading reading) {
  ReadingCheck check = check_reading(reading);
  if (check.usable) keep(std::move(reading));
  const auto lost =
      std::ranges::find(survived_ | std::views::reverse, Fault::touch_lost, &FaultReport::fault);
  if (check.fault == Fault::touch_lost && lost != survived_.rend()) {
    check.detail += ": " + lost->detail;
  }
  if (check.fault != Fault::none) stop_for(check.fault, check.detail);
  return check.usable;
}

ReadingCheck Executor::check_reading(hand::HandReading& reading) {
  return readings_->check(reading, {load_sensor_.sensed(), pause_, commanded_, trust_}, command_);
}

void Executor::keep(hand::HandReading reading) {
  log_.readings.push_back(std::move(reading));
  if (observer_.on_tick) observer_.on_tick(log_.readings.back(), command_);
}

void Executor::require_running() {
  if (fault_) throw SafetyStop(fault_);
  if (hand_failure_) stop_for(Fault::exception, fmt::format("the hand: {}", *hand_failure_));
}

void Executor::stop_for(Fault fault, std::string detail) {
  make_safe(fault, std::move(detail));
  throw SafetyStop(fault_);
}

void Executor::make_safe(Fault fault, std::string detail) noexcept {
  if (fault_) return;
  fault_ = {fault, std::move(detail), log_.readings.empty() ? 0 : time()};
  grip_.reset();
  const bool elsewhere = fault == Fault::not_at_start && !log_.readings.empty();
  command_ = elsewhere ? where_it_is() : commands_->last();
  for (int i = 0; i < kEasingTicks && commanded_ && !log_.readings.empty(); ++i) {
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

/// A command that moves nothing.
hand::HandCommand Executor::where_it_is() const {
  return {hand::actuator_positions(model_, reading().joints), reading().mount};
}

/// One step more, with a reading, so that the mount gives way to where it is, not to where it was.
/// What the fingers hold they keep, unless too much force is the fault.
void Executor::ease() {
  command_ = with_eased_mount(command_, reading(), safety_.options);
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
  if (check_reading(now).usable) keep(std::move(now));
}

void Executor::distrust(int finger, std::string detail) {
  if (trust_.trusted(finger)) survived_.push_back({Fault::touch_lost, std::move(detail), time()});
  trust_.distrust(finger);
}

void Executor::swap_touch(int finger, int other) {
  const auto& name = [&](int i) { return model_.fingers[static_cast<std::size_t>(i)].name; };
  survived_.push_back({Fault::touch_swapped,
                       fmt::format("{} reports what {} touches, and {} what {} touches",
                                   name(other), name(finger), name(finger), name(other)),
                       time()});
  trust_.swap(finger, other);
}

std::size_t Executor::limited_commands() const { return commands_->changed(); }

}  // namespace palpate::skills
