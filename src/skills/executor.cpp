// SPDX-License-Identifier: Apache-2.0
#include "palpate/skills/executor.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "palpate/core/error.hpp"

namespace palpate::skills {
namespace {

constexpr double kSettingOut = 0.4;  // s of a motion in which the load is that of setting out
constexpr double kSteady = 0.1;      // s after it over which the load of steady motion is averaged
constexpr int kLoadedTicks = 3;
constexpr double kLeverArm = 0.2;  // m: what a turn of 1 rad counts as a way of the hand

int ticks(double seconds) {
  return std::max(1, static_cast<int>(std::lround(seconds / hand::kTick)));
}

hand::BasePosition between(const hand::BasePosition& a, const hand::BasePosition& b, double share) {
  return {a.xyz + share * (b.xyz - a.xyz), a.ypr + share * (b.ypr - a.ypr)};
}

}  // namespace

Executor::Executor(hand::Hand& hand, const hand::HandModel& model, const hand::HandCommand& start,
                   Observer observer, const ModelFactory* models)
    : hand_(hand),
      model_(model),
      command_(start),
      observer_(std::move(observer)),
      models_(models),
      deadline_(std::numeric_limits<double>::infinity()) {
  tick();
}

const ModelFactory& Executor::models() const {
  if (!models_)
    throw BadInput("this skill plans ahead, and the robot was given no models to plan with");
  return *models_;
}

void Executor::mark(estimation::TouchEvent mark) {
  log_.moments.push_back({mark, log_.readings.size() - 1});
  if (observer_.on_event) observer_.on_event(mark);
}

void Executor::tick() {
  if (grip_) grip_->law.advance(command_, reading(), grip_->torque, grip_->active);
  log_.readings.push_back(hand_.step(command_));
  if (observer_.on_tick) observer_.on_tick(log_.readings.back(), command_);
}

MotionEnd Executor::tick_until(const StopCondition& stop) {
  tick();
  if (time() >= deadline_) return MotionEnd::timed_out;
  return stop && stop(reading()) ? MotionEnd::stopped : MotionEnd::reached;
}

MotionEnd Executor::wait(double seconds, const StopCondition& stop) {
  for (int i = ticks(seconds); i > 0; --i) {
    if (const auto end = tick_until(stop); end != MotionEnd::reached) return end;
  }
  return MotionEnd::reached;
}

MotionEnd Executor::move_base(const hand::BasePosition& target, double speed,
                              const StopCondition& stop) {
  const hand::BasePosition from = command_.base;
  const double way = std::max((target.xyz - from.xyz).norm(),
                              kLeverArm * (target.ypr - from.ypr).cwiseAbs().maxCoeff());
  const int count = ticks(way / speed);
  for (int i = 1; i <= count; ++i) {
    command_.base = between(from, target, static_cast<double>(i) / count);
    if (const auto end = tick_until(stop); end != MotionEnd::reached) return end;
  }
  return MotionEnd::reached;
}

MotionEnd Executor::follow(std::span<const hand::HandCommand> way, const StopCondition& stop) {
  for (const auto& command : way) {
    command_ = command;
    if (const auto end = tick_until(stop); end != MotionEnd::reached) return end;
  }
  return MotionEnd::reached;
}

MotionEnd Executor::move_fingers(const hand::ActuatorVector& posture, double seconds) {
  const hand::ActuatorVector from = command_.positions;
  const int count = ticks(seconds);
  for (int i = 1; i <= count; ++i) {
    command_.positions = from + static_cast<double>(i) / count * (posture - from);
    if (const auto end = tick_until({}); end != MotionEnd::reached) return end;
  }
  return MotionEnd::reached;
}

Executor::StopCondition lasting_load(const Executor& robot, const Eigen::Vector3d& direction,
                                     double load) {
  return [direction, load, start = robot.time(),
          loaded = 0](const hand::HandReading& reading) mutable {
    const bool now = reading.time > start + kSettingOut && direction.dot(reading.base_force) > load;
    loaded = now ? loaded + 1 : 0;
    return loaded >= kLoadedTicks;
  };
}

Executor::StopCondition rising_load(const Executor& robot, const Eigen::Vector3d& direction,
                                    double load) {
  return [direction, load, start = robot.time(), steady = 0.0, averaged = 0,
          loaded = 0](const hand::HandReading& reading) mutable {
    const double now = direction.dot(reading.base_force);
    const double moving = reading.time - start;
    if (moving <= kSettingOut) return false;
    if (averaged == 0 || moving <= kSettingOut + kSteady) {
      steady += (now - steady) / ++averaged;
      return false;
    }
    loaded = now - steady > load ? loaded + 1 : 0;
    return loaded >= kLoadedTicks;
  };
}

}  // namespace palpate::skills
