// SPDX-License-Identifier: Apache-2.0
#include "palpate/skills/grasp/lift_phase.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <span>

#include "estimation/slip.hpp"
#include "palpate/estimation/mean_load.hpp"
#include "palpate/hand/tip_forces.hpp"
#include "skills/grasp/grip_watch.hpp"

namespace palpate::skills {
namespace {

constexpr std::size_t kJudged = 50;  // readings at the end of the hold, averaged against noise

/// How many fingers touch with at least a force, in the mean over the last readings.
int touching_fingers(const estimation::EventLog& log, double force) {
  const auto window = std::span(log.readings).last(std::min(log.readings.size(), kJudged));
  int count = 0;
  for (int finger = 0; finger < std::ssize(log.readings.back().contacts); ++finger) {
    double sum = 0;
    for (const auto& reading : window) sum += hand::tip_force(reading, finger);
    count += sum >= force * static_cast<double>(window.size());
  }
  return count;
}

}  // namespace

/// The first part of the lift. @return whether the grip holds; else the hand is down again
bool LiftPhase::tries(Executor& robot) {
  const hand::MountPosition start = robot.command().mount;
  hand::MountPosition up = start;
  up.xyz.z() += std::min(options_.trial_height, options_.height);
  GripWatch grip(robot);
  const auto end =
      robot.move_mount(up, options_.trial_speed,
                       [&](const hand::HandReading& reading) { return grip.update(reading); });
  if (end != MotionEnd::stopped) return true;
  robot.move_mount(start, options_.trial_speed);
  return false;
}

PhaseEnd LiftPhase::run(Executor& robot, PickState& state) {
  hand::MountPosition up = robot.command().mount;
  up.xyz.z() += options_.height;
  gave_way_ = options_.trial_height > 0 && !tries(robot);
  if (gave_way_) return {false, "the grip gives way; back on the table"};
  robot.move_mount(up, options_.speed);
  robot.wait(options_.settle);
  const std::size_t settled = robot.log().readings.size() - 1;
  robot.wait(options_.hold);
  robot.add_event(estimation::TouchEvent::held);
  state.held_load = estimation::mean_load(robot.log(), kJudged);
  const int fingers = touching_fingers(robot.log(), options_.touch_force);
  const double slip = estimation::contact_slip(robot.log(), robot.model(), settled,
                                               robot.log().readings.size() - 1);

  const bool light = state.held_load <= options_.min_weight * weight_;
  const bool untouched = fingers < options_.min_fingers;
  const bool slipping = slip > options_.max_slip;
  const char* const outcome = light       ? "lost"
                              : untouched ? "contacts lost"
                              : slipping  ? "slipping"
                                          : "held";
  return {!light && !untouched && !slipping,
          fmt::format("{}: carries {:.2f} N of {:.2f} N, {} fingers in contact, slip {:.1f} mm",
                      outcome, state.held_load, weight_, fingers, 1e3 * slip)};
}

}  // namespace palpate::skills
