// SPDX-License-Identifier: Apache-2.0
#include "palpate/skills/release/set_down_phase.hpp"

#include <fmt/format.h>

#include <cmath>
#include <numbers>

#include "palpate/estimation/mean_load.hpp"
#include "palpate/hand/tip_forces.hpp"
#include "palpate/skills/stop_conditions.hpp"
#include "skills/release/opening.hpp"

namespace palpate::skills {
namespace {

constexpr double kHangingSeconds = 0.25;  // s in which the load that hangs is measured
constexpr double kCalmSeconds =
    0.75;                            // s, for the load's mean to hold nothing of the motion before
constexpr double kSettingOut = 0.3;  // s
constexpr double kKnockedAfter = 0.15;  // s of a faster motion, in which less is noticed
constexpr double kKnock = 1.5;          // N by which it has met something
constexpr int kHolding = 2;             // fingers that touch what has not been lost
constexpr double kTries = 6;            // places on a turn of the spiral
constexpr double kEarlyOfWall = 0.5;    // of a wall's height: that high, the object stands on it
constexpr double kAnyHeight = 1.0;      // m

/// Where the n-th try is: on rings around the first.
Eigen::Vector3d aside(int attempt, double spacing) {
  if (attempt == 0) return Eigen::Vector3d::Zero();
  const double ring = 1 + std::floor((attempt - 1) / kTries);
  const double angle = 2 * std::numbers::pi * (attempt - 1) / kTries;
  return ring * spacing * Eigen::Vector3d(std::cos(angle), std::sin(angle), 0);
}

hand::MountPosition moved(hand::MountPosition mount, const Eigen::Vector3d& way) {
  mount.xyz += way;
  return mount;
}

}  // namespace

LowerOptions never_refused(LowerOptions options) {
  options.early = kAnyHeight;
  return options;
}

PhaseEnd SetDownPhase::run(Executor& robot, PickState&) {
  const int tries = wall_ > 0 ? options_.tries : 1;
  int attempt = 0;
  for (; attempt < tries; ++attempt) {
    touchdown_ = lower(robot, aside(attempt, options_.spiral));
    if (touchdown_ != Touchdown::early) break;
    robot.move_mount(moved(contact_, {0, 0, options_.back_off}), options_.slow_speed);
  }
  switch (touchdown_) {
    case Touchdown::lost:
      return {false, "lost: nothing hangs in the hand"};
    case Touchdown::nothing:
      return {false,
              fmt::format("no table down to {:.0f} mm below the target", 1e3 * options_.beyond)};
    case Touchdown::early:
      return {false, fmt::format("refused: contact {:.1f} mm too high, tried {} places",
                                 1e3 * height_error_, attempt)};
    case Touchdown::flat:
      break;
  }
  T_world_object_ = estimation::mean_mount(robot.log(), 5).pose() * goal_.T_mount_object;
  released_ = true;
  release(robot, options_);
  return {true, fmt::format("contact at {:+.1f} mm{}, let go", 1e3 * height_error_,
                            attempt > 0 ? fmt::format(", try {}", attempt + 1) : "")};
}

/// Slowly, until the table bears the object. @return how that has failed, if it has
std::optional<SetDownPhase::Touchdown> SetDownPhase::descend(
    Executor& robot, const hand::MountPosition& at_goal) const {
  hand::MountPosition start = at_goal;
  start.xyz.z() = robot.command().mount.xyz.z();
  robot.move_mount(start, options_.slow_speed);
  robot.wait(kCalmSeconds);
  const double load = estimation::mean_load(robot.log());
  const bool held = hand::touching_fingers(robot.reading()) >= kHolding;
  if (load < options_.contact_load && !held) return Touchdown::lost;

  const hand::MountPosition low = moved(at_goal, {0, 0, -options_.beyond});
  const auto borne = load_below(load - options_.contact_load, robot.time() + kSettingOut);
  const bool met = robot.move_mount(low, options_.slow_speed, borne) == MotionEnd::stopped;
  return met ? std::nullopt : std::optional(Touchdown::nothing);
}

/// Goes down from over the goal until the table bears the object and a little more.
SetDownPhase::Touchdown SetDownPhase::lower(Executor& robot, const Eigen::Vector3d& aside) {
  const hand::MountPosition measured = estimation::mean_mount(robot.log());
  const hand::MountPosition& command = robot.command().mount;
  hand::MountPosition at_goal = moved(goal_.mount, aside + command.xyz - measured.xyz);
  at_goal.ypr += command.ypr - measured.ypr;
  const hand::MountPosition over = moved(at_goal, {0, 0, std::max(options_.near, 1.5 * wall_)});
  robot.wait(kHangingSeconds);
  const double hangs = estimation::mean_load(robot.log());
  const bool knocked = command.xyz.z() > over.xyz.z() &&
                       robot.move_mount(over, options_.speed,
                                        load_below(hangs - kKnock, robot.time() + kKnockedAfter)) ==
                           MotionEnd::stopped;
  if (!knocked) {
    if (const auto end = descend(robot, at_goal)) return *end;
  }
  contact_ = robot.command().mount;
  height_error_ = robot.reading().mount.xyz.z() - goal_.mount.xyz.z();
  if (height_error_ > options_.early + goal_.sunk) return Touchdown::early;
  robot.move_mount(moved(contact_, {0, 0, -options_.max_press}), options_.slow_speed,
                   load_below(-options_.press));
  // The object sank in the hand when it was lifted, so that any contact comes early, by more than a
  // low wall is high. Where all of the load is borne, it has been pushed back to where it was in
  // the hand when the fingers closed: over the table the hand is then as low as expected, and over
  // a wall it is not.
  const double pressed_error = robot.reading().mount.xyz.z() - goal_.mount.xyz.z();
  if (wall_ <= 0 || pressed_error <= kEarlyOfWall * wall_) return Touchdown::flat;
  height_error_ = pressed_error;
  return Touchdown::early;
}

}  // namespace palpate::skills
