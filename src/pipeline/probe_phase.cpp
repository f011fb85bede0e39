// SPDX-License-Identifier: Apache-2.0
#include "palpate/pipeline/probe_phase.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "load.hpp"
#include "palpate/pipeline/held_object.hpp"
#include "probe_finger.hpp"
#include "probe_regrasp.hpp"
#include "probe_roll.hpp"

namespace palpate::pipeline {
namespace {

constexpr double kStepSeconds = 10;     // s that a touch or a roll takes at most, and back
constexpr double kRegraspSeconds = 14;  // s, of an object on the table
constexpr double kLiftSeconds = 6;      // s more, where it is to be put down and lifted again
constexpr double kLeastWeight = 0.5;    // of the object's weight, that must still hang
constexpr double kPlannedRate = 1.0;    // rad/s, of the closing planned; the path is that of any

int regrasps_made(const TouchLog& log) {
  const auto moments = log.since_release();
  return static_cast<int>(std::count_if(moments.begin(), moments.end(), [](const auto& moment) {
    return moment.mark == Mark::opened;
  }));
}

GraspTool tool_of(const Robot& robot, const GraspOptions& options) {
  const GraspRecipe& recipe = options.top;
  const hand::ClosingLaw law(robot.actuators(), kPlannedRate, recipe.thumb_limit);
  return {closing_path(robot.model(), open_posture(recipe), law),
          {{recipe.pitch, recipe.roll}, {options.steep_pitch, recipe.roll}}};
}

/// What there is to be learnt about which of the poses in question is true, nats.
double entropy(const localization::Posterior& posterior) {
  const auto poses = poses_of(posterior);
  double total = 0, sum = 0;
  for (const WeightedPose& pose : poses) total += pose.weight;
  for (const WeightedPose& pose : poses) {
    const double share = pose.weight / total;
    if (share > 0) sum -= share * std::log(share);
  }
  return sum;
}

/// What could be done next, each with what it promises.
struct Choices {
  std::optional<FingerProbes::Move> touch;
  std::optional<Roll> roll;
  std::optional<TellingGrasp> grasp;

  /// Leaves the one that tells most a second.
  void keep_best(double worth) {
    const auto rate = [&](const auto& choice) {
      return choice && choice->promise.rate() >= worth ? choice->promise.rate() : -1.0;
    };
    const double best = std::max({rate(touch), rate(roll), rate(grasp)});
    if (rate(touch) < std::max(best, 0.0)) touch.reset();
    if (touch || rate(roll) < std::max(best, 0.0)) roll.reset();
    if (touch || roll || rate(grasp) < std::max(best, 0.0)) grasp.reset();
  }
};

/// Where the object comes to stand when the hand goes back to where it closed.
localization::Posterior put_back(const Robot& robot, localization::Posterior posterior) {
  const auto& readings = robot.log().readings;
  move(readings[*robot.log().at(Mark::closed)].base.pose() * robot.reading().base.pose().inverse(),
       posterior);
  return posterior;
}

std::optional<TellingGrasp> other_grasp(const Robot& robot, const PickState& state,
                                        const localization::ObjectModel& object,
                                        const GraspOptions& grasp, bool hangs) {
  TellingGraspOptions options;
  options.plan.press = pressure(grasp, object.object());
  options.worst_cost = grasp.most_imbalance;
  options.avoid = state.tried_yaws;
  options.seconds = kRegraspSeconds + (hangs ? kLiftSeconds : 0);
  const auto& posterior = state.estimate.posterior;
  return most_telling_grasp(object, hangs ? put_back(robot, posterior) : posterior,
                            tool_of(robot, grasp), options);
}

}  // namespace

PhaseEnd ProbePhase::run(Robot& robot, PickState& state) {
  state.next_grasp.reset();
  FingerProbes fingers(object_, options_, pressure(grasp_, object_.object()));
  const auto weight = [&] {
    const auto& modes = state.estimate.posterior.modes;
    return modes.empty() ? 0.0 : modes[0].weight;
  };
  const double before = weight();
  const double last_start = robot.time() + time_limit() - kStepSeconds;
  const bool hangs = instant_ == Mark::held;
  int touches = 0, rolls = 0;
  bool holds = true, slipped = false;
  while (holds && !slipped && weight() > 0 && weight() <= options_.certain &&
         robot.time() < last_start) {
    const auto& posterior = state.estimate.posterior;
    Choices next;
    if (touches < options_.most) {
      next.touch = fingers.choose(robot, posterior, RandomStream(seed_, "probe"));
    }
    if (next.touch) {  // of draws, which also differ by each pose's own error
      auto& information = next.touch->promise.information;
      information = std::min(information, entropy(posterior));
    }
    if (hangs && rolls < options_.rolls) {
      const auto contacts = contacts_at(robot, robot.log().readings.size() - 1);
      next.roll = most_telling_roll(robot, object_, posterior, contacts);
    }
    if (regrasps_made(robot.log()) < options_.regrasps) {
      next.grasp = other_grasp(robot, state, object_, grasp_, hangs);
    }
    next.keep_best(options_.worth);
    if (next.grasp) state.next_grasp = next.grasp->plan;
    if (!next.touch && !next.roll) break;
    if (next.touch) {
      holds = fingers.make(robot, *next.touch);
      ++touches;
    } else {
      slipped = !roll(robot, object_, posterior, *next.roll, locate_.errors, seed_);
      ++rolls;
    }
    robot.mark(instant_);
    state.estimate = locate(object_, robot.model(), robot.log(), locate_, seed_, instant_);
  }
  const bool lost =
      hangs ? mean_load(robot.log()) < kLeastWeight * object_.object().mass * kGravity : !holds;
  return {!lost && !slipped,
          fmt::format("{} touch{}, {} roll{}, certainty {:.2f} -> {:.2f}{}", touches,
                      touches == 1 ? "" : "es", rolls, rolls == 1 ? "" : "s", before, weight(),
                      state.next_grasp ? "; another grasp tells more" : "")};
}

}  // namespace palpate::pipeline
