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
constexpr double kSecondsAFinger = 20.0;  // amply

}  // namespace

double TouchTestPhase::time_limit() const { return kSecondsAFinger * hand::kMaxFingers; }

/// A fingertip with which the hand cannot press on the table counts as insensitive: it was held up.
bool TouchTestPhase::is_insensitive(Executor& robot, int finger) const {
  const auto touch = calibration_touch(robot.model(), finger);
  if (!touch || !is_reachable(robot, *touch, options_)) return true;
  take_attitude(robot, *touch, options_);
  const double contact_height = -lowest(robot.model(), *touch);
  for (int i = 0; i < kPresses; ++i) {
    robot.move_mount(touch->mount(options_, contact_height + kReach), options_.travel_speed);
    tare(robot);
    const TablePress press = press_table(robot, *touch, options_, contact_height - kReach);
    rise(robot, kTravelHeight, options_.travel_speed);
    if (press != TablePress::unsensed) return false;
  }
  return true;
}

PhaseEnd TouchTestPhase::run(Executor& robot, PickState& state) {
  const auto high = [&] {
    const hand::HandCommand& now = robot.command();
    const double low = lowest_part(robot.model(), now.positions, attitude_of(now.mount));
    const double free = std::max(kFreeHeight, state.clear_height - low);
    rise(robot, std::max(0.0, free - now.mount.xyz.z()), options_.travel_speed);
  };
  std::vector<std::string> insensitive;
  for (const int finger : robot.trust().suspects()) {
    high();
    const std::string& name = robot.model().fingers[static_cast<std::size_t>(finger)].name;
    if (!is_insensitive(robot, finger)) {
      robot.trust().clear(finger);
      continue;
    }
    robot.distrust(finger, fmt::format("{} does not sense what it presses on", name));
    insensitive.push_back(name);
  }
  high();
  return {true, insensitive.empty() ? "all fingertips sense contact"
                                    : fmt::format("insensitive: {}", fmt::join(insensitive, ", "))};
}

}  // namespace palpate::skills
