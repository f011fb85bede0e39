// SPDX-License-Identifier: Apache-2.0
#include "skills/explore/touch_test_phase.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "skills/explore/table_press.hpp"
#include "skills/motion/lowest_part.hpp"
#include "skills/motion/motion_constants.hpp"

namespace palpate::skills {
namespace {

constexpr double kReach = 0.014;          // m over and under the table
constexpr int kPresses = 2;               // that must not be sensed
constexpr double kSecondsAFinger = 40.0;  // amply, with the one that it may be swapped with

/// Lifts the hand so that its lowest part is clear of the object.
void rise_clear(Executor& robot, double clear_height, double speed) {
  const hand::HandCommand& now = robot.command();
  const double low = lowest_part(robot.model(), now.positions, attitude_of(now.mount));
  const double free = std::max(kFreeHeight, clear_height - low);
  rise(robot, std::max(0.0, free - now.mount.xyz.z()), speed);
}

}  // namespace

double TouchTestPhase::time_limit() const { return kSecondsAFinger * hand::kMaxFingers; }

/// A fingertip with which the hand cannot press on the table counts as insensitive: it was held up.
TouchTestPhase::Result TouchTestPhase::test(Executor& robot, double clear_height, int finger,
                                            UnsensedPresses& unsensed) const {
  const auto touch = calibration_touch(robot.model(), finger);
  if (!touch) return Result::insensitive;
  rise_clear(robot, clear_height, options_.travel_speed);
  if (!is_reachable(robot, *touch, options_)) return Result::untested;
  take_attitude(robot, *touch, options_);
  const double contact_height = -lowest(robot.model(), *touch);
  for (int i = 0; i < kPresses; ++i) {
    robot.move_mount(touch->mount(options_, contact_height + kReach), options_.travel_speed);
    tare(robot);
    const TablePress press = press_table(robot, *touch, options_, contact_height - kReach);
    rise(robot, kTravelHeight, options_.travel_speed);
    if (!press.met || press.sensed_by(finger)) return Result::sensitive;
    unsensed.add(finger, press);
  }
  return Result::insensitive;
}

/// The fingertip that reports what this insensitive one touches, if that holds the other way round,
/// too.
std::optional<int> TouchTestPhase::swapped_with(Executor& robot, double clear_height, int finger,
                                                UnsensedPresses& unsensed) const {
  const std::optional<int> other = unsensed.reporter(finger);
  if (!other || test(robot, clear_height, *other, unsensed) != Result::insensitive) return {};
  return unsensed.swapped_with(finger, kPresses);
}

PhaseEnd TouchTestPhase::run(Executor& robot, PickState& state) {
  const auto name = [&](int finger) -> const std::string& {
    return robot.model().fingers[static_cast<std::size_t>(finger)].name;
  };
  std::vector<std::string> found;
  for (const int finger : robot.trust().suspects()) {
    if (robot.trust().cleared(finger)) continue;  // with the one that it was swapped with
    UnsensedPresses unsensed;
    const Result result = test(robot, state.clear_height, finger, unsensed);
    if (result == Result::sensitive) {
      robot.trust().clear(finger);
    } else if (result == Result::untested) {
      robot.trust().end_suspicion(finger);
      found.push_back(fmt::format("out of reach: {}", name(finger)));
    } else if (const auto other = swapped_with(robot, state.clear_height, finger, unsensed)) {
      robot.swap_touch(finger, *other);
      robot.trust().clear(finger);
      robot.trust().clear(*other);
      found.push_back(fmt::format("swapped: {} and {}", name(finger), name(*other)));
    } else {
      robot.distrust(finger, fmt::format("{} does not sense what it presses on", name(finger)));
      found.push_back(fmt::format("insensitive: {}", name(finger)));
    }
  }
  rise_clear(robot, state.clear_height, options_.travel_speed);
  return {true, found.empty() ? "all fingertips sense contact"
                              : fmt::format("{}", fmt::join(found, ", "))};
}

}  // namespace palpate::skills
