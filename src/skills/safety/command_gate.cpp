// SPDX-License-Identifier: Apache-2.0
#include "skills/safety/command_gate.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "palpate/core/error.hpp"

namespace palpate::skills {
namespace {

constexpr double kMaxTicks = 1e9;
constexpr double kRounding = 1e-9;  // relative, of speeds that are differences of positions

/// At most kMaxTicks; none for NaN, which no command passes the gate with.
int ticks_at_least(double seconds) {
  const double ticks = std::ceil(seconds / hand::kTick - kRounding);
  return ticks > 0 ? static_cast<int>(std::min(ticks, kMaxTicks)) : 0;
}

/// Largest step of one tick after one of a speed.
double largest_step(double speed, double max_speed, double max_acceleration) {
  return hand::kTick * (1 + kRounding) *
         std::min(max_speed, speed + max_acceleration * hand::kTick);
}

/// The speed with which a step along `way` begins: to stop is allowed at once, to turn back is not.
double speed_along(const Eigen::Vector3d& velocity, const Eigen::Vector3d& way) {
  return velocity.dot(way) < 0 ? 0 : velocity.norm();
}

void require_finite(const hand::HandCommand& command) {
  if (command.positions.allFinite() && command.mount.xyz.allFinite() &&
      command.mount.ypr.allFinite()) {
    return;
  }
  throw BadInput(fmt::format("mount at {} {} {} m, turned by {} {} {} rad, sum of the actuators {}",
                             command.mount.xyz.x(), command.mount.xyz.y(), command.mount.xyz.z(),
                             command.mount.ypr.x(), command.mount.ypr.y(), command.mount.ypr.z(),
                             command.positions.sum()));
}

void require_size(const hand::ActuatorVector& positions, std::size_t actuators) {
  if (positions.size() == static_cast<Eigen::Index>(actuators)) return;
  throw BadInput(
      fmt::format("{} actuators are commanded, the hand has {}", positions.size(), actuators));
}

}  // namespace

Eigen::Vector3d limited_step(const Eigen::Vector3d& from, const Eigen::Vector3d& to, double step) {
  const double way = (to - from).norm();
  return way <= step ? to : from + step / way * (to - from);
}

SpeedProfile::SpeedProfile(double seconds) : steady_(hand::whole_ticks(seconds)) {}

void SpeedProfile::limit(double way, double max_speed, double max_acceleration) {
  steady_ = std::max({steady_, ticks_at_least(way / max_speed),
                      ticks_at_least(std::sqrt(way / max_acceleration))});
  ramp_way_ = std::max(ramp_way_, way / max_acceleration);
}

void SpeedProfile::stretch(double times) {
  if (times <= 1) return;
  steady_ = static_cast<int>(std::min(std::ceil(steady_ * times), kMaxTicks));
  ramp_way_ *= times * times;
}

int SpeedProfile::ramp() const {
  return std::max(1, ticks_at_least(ramp_way_ / (steady_ * hand::kTick)));
}

double SpeedProfile::share(int tick) const {
  const int m = ramp();
  // In ticks of full speed: the speed rises by 1/m of it a tick, and falls alike.
  const auto gone = [m](int t) { return t < m ? t * (t + 1) / (2.0 * m) : t - 0.5 * (m - 1); };
  const double done = 2 * tick < ticks() ? gone(tick) : steady_ - gone(ticks() - tick);
  return done / steady_;
}

CommandGate::CommandGate(const std::vector<hand::Actuator>& actuators,
                         const hand::HandCommand& start, const SafetyOptions& options)
    : actuators_(actuators),
      options_(options),
      last_(start),
      finger_speeds_(hand::ActuatorVector::Zero(start.positions.size())) {
  require_size(start.positions, actuators_.size());
}

hand::HandCommand CommandGate::limited(const hand::HandCommand& wanted) {
  require_size(wanted.positions, actuators_.size());
  require_finite(wanted);
  hand::HandCommand allowed = wanted;
  limit_mount(allowed.mount);
  limit_fingers(allowed.positions);
  changed_ += allowed.positions != wanted.positions || allowed.mount.xyz != wanted.mount.xyz ||
              allowed.mount.ypr != wanted.mount.ypr;
  last_ = allowed;
  return allowed;
}

void CommandGate::limit_mount(hand::MountPosition& mount) {
  const double reach = mount.xyz.norm();
  if (reach > options_.workspace) mount.xyz *= options_.workspace / reach;
  const double slide = speed_along(slide_, mount.xyz - last_.mount.xyz);
  const double turn = speed_along(turn_, mount.ypr - last_.mount.ypr);
  mount.xyz = limited_step(last_.mount.xyz, mount.xyz,
                           largest_step(slide, options_.mount_speed, options_.mount_acceleration));
  mount.ypr = limited_step(last_.mount.ypr, mount.ypr,
                           largest_step(turn, options_.turn_speed, options_.turn_acceleration));
  slide_ = (mount.xyz - last_.mount.xyz) / hand::kTick;
  turn_ = (mount.ypr - last_.mount.ypr) / hand::kTick;
}

void CommandGate::limit_fingers(hand::ActuatorVector& positions) {
  for (Eigen::Index i = 0; i < positions.size(); ++i) {
    const hand::Range& range = actuators_[static_cast<std::size_t>(i)].command;
    const double before = last_.positions[i];
    const double step =
        largest_step(finger_speeds_[i], options_.finger_speed, options_.finger_acceleration);
    positions[i] =
        std::clamp(std::clamp(positions[i], range.low, range.high), before - step, before + step);
    finger_speeds_[i] = std::abs(positions[i] - before) / hand::kTick;
  }
}

}  // namespace palpate::skills
