// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <exception>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "palpate/core/error.hpp"
#include "palpate/skills/executor.hpp"
#include "skills/motion/stretched_way.hpp"
#include "skills/safety/command_gate.hpp"

namespace palpate::skills {
namespace {

constexpr double kLeverArm = 0.2;            // m: what a turn of 1 rad counts as a way of the hand
constexpr double kHeldAcceleration = 2;      // m/s^2, of a mount whose hand holds an object
constexpr double kHeldTurnAcceleration = 8;  // rad/s^2
constexpr int kCheckedSteps = 100;           // of a way that is asked about, at least
constexpr double kCheckedTurn = 0.032;       // rad of the mount in one of them, at most

/// s that the way takes at a speed (m/s).
double seconds_of(const hand::MountPosition& from, const hand::MountPosition& target,
                  double speed) {
  const double turn = kLeverArm * (target.ypr - from.ypr).cwiseAbs().maxCoeff();
  return std::max((target.xyz - from.xyz).norm(), turn) / speed;
}

/// A tick after the other.
std::vector<hand::MountPosition> straight_path(const hand::MountPosition& from,
                                               const hand::MountPosition& target,
                                               const SpeedProfile& profile) {
  std::vector<hand::MountPosition> way;
  for (int i = 1; i <= profile.ticks(); ++i) {
    way.push_back(between(from, target, profile.share(i)));
  }
  return way;
}

}  // namespace

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

/// What the hand throws meanwhile stops the robot before it moves: require_running().
template <class Value>
Value Executor::ask_hand(const std::function<Value()>& ask) const {
  try {
    return ask();
  } catch (const std::exception& error) {
    if (!hand_failure_) hand_failure_ = error.what();
  } catch (...) {
    if (!hand_failure_) hand_failure_ = "an unknown exception";
  }
  return {};
}

/// Of a way in the world whose z = 0 is the table.
hand::PathFeasibility Executor::check_path(std::vector<hand::MountPosition> way) const {
  for (hand::MountPosition& mount : way) mount.xyz.z() += table_height_;
  return ask_hand<hand::PathFeasibility>([&] {
    hand::PathFeasibility checked = hand_.check_path(way);
    const double seconds = checked.stretch * hand::kTick * static_cast<double>(way.size());
    if (seconds <= safety_.options.max_log) return checked;
    throw BadInput(fmt::format("check_path: the path takes {} times as long", checked.stretch));
  });
}

hand::MountLimits Executor::mount_limits() const {
  return ask_hand<hand::MountLimits>([&] {
    const hand::MountLimits limits = hand_.mount_limits();
    if (limits.acceleration > 0 && limits.turn_acceleration > 0) return limits;
    throw BadInput(fmt::format("mount_limits: accelerations of {} m/s^2 and {} rad/s^2",
                               limits.acceleration, limits.turn_acceleration));
  });
}

/// @throws SafetyStop for a motion that would never end
void Executor::require_motion(const hand::MountPosition& target, double speed) {
  const double seconds = seconds_of(command_.mount, target, speed);
  if (speed > 0 && std::isfinite(speed) && !(seconds > safety_.options.max_log)) return;
  stop_for(Fault::invalid_command,
           fmt::format("a motion at {} m/s, which would take {} s", speed, seconds));
}

std::string Executor::obstacle(const hand::MountPosition& target) const {
  const double reach = target.xyz.norm(), workspace = safety_.options.workspace;
  if (reach > workspace) {
    return fmt::format("the mount would be {:.3f} m from the origin, {:.3f} m are allowed", reach,
                       workspace);
  }
  return obstacle_along({target});
}

/// Why the mount cannot be brought along straight lines from where it is commanded to be.
std::string Executor::obstacle_along(const std::vector<hand::MountPosition>& corners) const {
  std::vector<hand::MountPosition> way;
  hand::MountPosition from = command_.mount;
  for (const hand::MountPosition& corner : corners) {
    const double turn = (corner.ypr - from.ypr).cwiseAbs().maxCoeff();
    const int steps = std::max(kCheckedSteps, static_cast<int>(std::ceil(turn / kCheckedTurn)));
    for (int i = 1; i <= steps; ++i) {
      way.push_back(between(from, corner, static_cast<double>(i) / steps));
    }
    from = corner;
  }
  return check_path(std::move(way)).obstacle;
}

MountPath Executor::path_to(std::vector<hand::MountPosition> targets) const {
  MountPath path{std::move(targets), {}};
  path.obstacle = obstacle_along(path.corners);
  if (path.obstacle.empty() || path.corners.empty()) return path;
  const hand::MountPosition& here = command_.mount;
  const hand::MountPosition& there = path.corners.front();
  const hand::MountPosition turned{here.xyz, there.ypr}, moved{there.xyz, here.ypr};
  // The turn is made at the higher end.
  const bool higher = here.xyz.z() >= there.xyz.z(), lower = here.xyz.z() <= there.xyz.z();
  for (const auto& [possible, corner] : {std::pair(higher, turned), std::pair(lower, moved)}) {
    if (!possible) continue;
    std::vector<hand::MountPosition> corners = path.corners;
    corners.insert(corners.begin(), corner);
    if (obstacle_along(corners).empty()) return {std::move(corners), {}};
  }
  return path;
}

std::optional<planning::ArmStart> Executor::arm_start() const {
  hand::ArmPosture posture = ask_hand<hand::ArmPosture>([&] { return hand_.arm_posture(); });
  if (!posture.arm) return std::nullopt;
  return planning::ArmStart{std::move(posture), command_.mount, table_height_};
}

MotionEnd Executor::move_mount(const hand::MountPosition& target, double speed,
                               const StopCondition& stop) {
  if (stop) speed = std::min(speed, mount_limits().guarded_speed);
  require_motion(target, speed);
  if (stop) return move_straight(target, speed, stop);
  for (const hand::MountPosition& corner : path_to({target}).corners) {
    if (const auto end = move_straight(corner, speed, {}); end != MotionEnd::reached) return end;
  }
  return MotionEnd::reached;
}

MotionEnd Executor::move_straight(const hand::MountPosition& target, double speed,
                                  const StopCondition& stop) {
  const hand::MountPosition from = command_.mount;
  SpeedProfile profile(seconds_of(from, target, speed));
  limit_mount(target, profile);
  const hand::PathFeasibility checked = check_path(straight_path(from, target, profile));
  // A guarded move goes as far as it can: what it is to meet may end it before.
  const bool whole = checked.obstacle.empty();
  if (!whole && (!stop || checked.feasible == 0)) throw Unreachable(checked.obstacle);
  const double last = whole ? 1 : profile.share(static_cast<int>(checked.feasible));
  profile.stretch(checked.stretch);
  for (int i = 1; i <= profile.ticks() && (whole || profile.share(i) <= last); ++i) {
    command_.mount = between(from, target, profile.share(i));
    if (const auto end = tick_until(stop); end != MotionEnd::reached) return end;
  }
  if (!whole) throw Unreachable(checked.obstacle);
  return MotionEnd::reached;
}

MotionEnd Executor::follow(std::span<const hand::HandCommand> way, const StopCondition& stop) {
  std::vector<hand::MountPosition> mounts;
  for (const auto& command : way) mounts.push_back(command.mount);
  const hand::PathFeasibility checked = check_path(std::move(mounts));
  if (!checked.obstacle.empty()) throw Unreachable(checked.obstacle);
  const double times = std::max(1.0, checked.stretch);
  const auto ticks = static_cast<std::size_t>(std::ceil(static_cast<double>(way.size()) * times));
  for (const auto& command : stretched(command_, way, ticks)) {
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
  require_motion(target.mount, speed);
  const hand::HandCommand from = command_;
  SpeedProfile profile(std::max(seconds, seconds_of(from.mount, target.mount, speed)));
  limit_mount(target.mount, profile);
  limit_fingers(target.positions, profile);
  const hand::PathFeasibility checked =
      check_path(straight_path(from.mount, target.mount, profile));
  if (!checked.obstacle.empty()) throw Unreachable(checked.obstacle);
  profile.stretch(checked.stretch);
  for (int i = 1; i <= profile.ticks(); ++i) {
    command_.mount = between(from.mount, target.mount, profile.share(i));
    command_.positions = from.positions + profile.share(i) * (target.positions - from.positions);
    if (const auto end = tick_until({}); end != MotionEnd::reached) return end;
  }
  return MotionEnd::reached;
}

void Executor::limit_mount(const hand::MountPosition& target, SpeedProfile& profile) const {
  const SafetyOptions& limits = safety_.options;
  hand::MountLimits gentle = mount_limits();
  if (log_.at(estimation::TouchEvent::closed)) {
    gentle.acceleration = std::min(gentle.acceleration, kHeldAcceleration);
    gentle.turn_acceleration = std::min(gentle.turn_acceleration, kHeldTurnAcceleration);
  }
  profile.limit((target.xyz - command_.mount.xyz).norm(), limits.mount_speed,
                std::min(limits.mount_acceleration, gentle.acceleration));
  profile.limit((target.ypr - command_.mount.ypr).norm(), limits.turn_speed,
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
