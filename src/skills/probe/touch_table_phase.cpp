// SPDX-License-Identifier: Apache-2.0
#include "skills/probe/touch_table_phase.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "palpate/core/gravity.hpp"
#include "palpate/estimation/mean_load.hpp"
#include "skills/probe/table_touch.hpp"

namespace palpate::skills {
namespace {

constexpr double kBackSpeed = 0.1;       // m/s
constexpr double kOneTouchSeconds = 12;  // s that a touch takes at most, and the way back
constexpr double kStillHangs = 0.5;      // of the object's weight, that must still hang

}  // namespace

PhaseEnd TouchTablePhase::run(Executor& robot, PickState& state) {
  const auto& posterior = state.estimate.posterior;
  if (posterior.modes.empty()) return {true, "no pose"};
  const double weight = kGravity * estimator_.object().object().mass;
  const double before = localization::best_probability(posterior);
  const double last_start = robot.time() + time_limit() - kOneTouchSeconds - hold_;
  const hand::MountPosition start = robot.command().mount;
  TableTouchChoice choice(robot, estimator_.object(), posterior,
                          RandomStream(estimator_.seed(), "touch table"));
  int tries = 0, touches = 0;
  double tight = choice.tight_share();
  for (; tries < options_.table_touches && tight <= options_.tight && robot.time() < last_start;
       ++tries) {
    const auto touch = choice.next();
    if (!touch || touch->expected_gain.rate() < options_.min_gain_rate) break;
    const auto lowest = touch_table(robot, choice, *touch, kStillHangs * weight);
    choice.made(*touch, lowest);
    touches += lowest.has_value();
    tight = choice.tight_share();
  }
  if (tries == 0) {
    return {true, tight > options_.tight ? fmt::format("tight enough ({:.2f})", tight)
                                         : "would add no information"};
  }
  robot.move_mount(start, kBackSpeed);
  robot.wait(std::max(hold_, kSettleSeconds));
  if (estimation::mean_load(robot.log()) < kStillHangs * weight) {
    return {false, "lost on the table"};
  }
  robot.add_event(estimation::TouchEvent::held);
  if (touches > 0) {
    state.estimate =
        estimator_.held(robot.model(), robot.log(), robot.log().at(estimation::TouchEvent::held));
  }
  return {true, fmt::format("{} of {} touches, probability {:.2f} -> {:.2f}", touches, tries,
                            before, localization::best_probability(posterior))};
}

}  // namespace palpate::skills
