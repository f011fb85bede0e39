// SPDX-License-Identifier: Apache-2.0
#include "skills/explore/table_press.hpp"

#include <algorithm>

#include "palpate/hand/tip_forces.hpp"
#include "skills/motion/lowest_part.hpp"
#include "skills/motion/take_posture.hpp"

namespace palpate::skills {
namespace {

constexpr double kPostureSeconds = 0.3;  // s
constexpr double kUnsensedLoad = 4.0;    // N at which the table is there, sensed or not
constexpr int kPressedTicks = 3;         // of it in a row

/// Stop condition: the hand presses downwards, be it sensed or not.
Executor::StopCondition pressing_down() {
  return [loaded = 0](const hand::HandReading& reading) mutable {
    loaded = -reading.mount_force.z() > kUnsensedLoad ? loaded + 1 : 0;
    return loaded >= kPressedTicks;
  };
}

/// The fingertip that reports the greatest force, if more than `min_force`, N.
std::optional<int> most_pressed(const hand::HandReading& reading, double min_force) {
  std::optional<int> most;
  for (int finger = 0; finger < static_cast<int>(reading.contacts.size()); ++finger) {
    const double force = hand::tip_force(reading, finger);
    if (force <= min_force) continue;
    min_force = force;
    most = finger;
  }
  return most;
}

/// Goes to an attitude and a posture at once, above the table.
void move_above(Executor& robot, const CalibrationTouch& touch, const CalibrateOptions& options) {
  const hand::HandCommand& now = robot.command();
  const double low = lowest_on_way(robot.model(), now.positions, attitude_of(now.mount),
                                   touch.posture, touch.attitude);
  const double high = std::max(now.mount.xyz.z(), kTravelHeight - low);
  rise(robot, high - now.mount.xyz.z(), options.travel_speed);
  robot.move_hand({touch.posture, touch.mount(options, high)}, options.travel_speed,
                  kPostureSeconds);
}

}  // namespace

void rise(Executor& robot, double way, double speed) {
  hand::MountPosition up = robot.command().mount;
  up.xyz.z() += way;
  robot.move_mount(up, speed);
}

double lowest(const hand::Description& hand, const CalibrationTouch& touch) {
  return lowest_part(hand, touch.posture, touch.attitude);
}

void take_attitude(Executor& robot, const CalibrationTouch& touch,
                   const CalibrateOptions& options) {
  if (fingers_meet(robot, touch.posture)) {
    CalibrationTouch stretched = touch;
    stretched.posture = robot.model().postures.stretched;
    move_above(robot, stretched, options);
  }
  move_above(robot, touch, options);
}

bool is_reachable(const Executor& robot, const CalibrationTouch& touch,
                  const CalibrateOptions& options) {
  const double contact_height = -lowest(robot.model(), touch);
  return robot.obstacle(touch.mount(options, contact_height + kTravelHeight)).empty() &&
         robot.obstacle(touch.mount(options, contact_height)).empty();
}

TablePress press_table(Executor& robot, const CalibrationTouch& touch,
                       const CalibrateOptions& options, double height) {
  bool sensed = false;
  const auto loaded = pressing_down();
  const auto stop = [&](const hand::HandReading& reading) {
    sensed = hand::tip_force(reading, touch.finger) > options.touch_force;
    return sensed || loaded(reading);
  };
  const auto end = robot.move_mount(touch.mount(options, height), options.speed, stop);
  if (end != MotionEnd::stopped) return {};
  if (sensed) return {true, touch.finger};
  return {true, most_pressed(robot.reading(), options.touch_force)};
}

void UnsensedPresses::add(int finger, const TablePress& press) {
  OfFinger& of = of_[static_cast<std::size_t>(finger)];
  if (press.sensed_by(finger)) {
    of = {};
    return;
  }
  const bool same = of.count == 0 || of.reporter == press.reported_by;
  of.reporter = same ? press.reported_by : std::nullopt;
  ++of.count;
}

std::optional<int> UnsensedPresses::swapped_with(int finger, int count) const {
  const std::optional<int> other = reporter(finger);
  const bool swapped = other && reporter(*other) == finger && this->count(finger) >= count &&
                       this->count(*other) >= count;
  return swapped ? other : std::nullopt;
}

}  // namespace palpate::skills
