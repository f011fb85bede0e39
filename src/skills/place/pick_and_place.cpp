// SPDX-License-Identifier: Apache-2.0
#include "palpate/skills/place/pick_and_place.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <utility>

namespace palpate::skills {
namespace {

void append(std::vector<PhaseReport>& phases, std::vector<PhaseReport>& more) {
  phases.insert(phases.end(), std::make_move_iterator(more.begin()),
                std::make_move_iterator(more.end()));
  more.clear();
}

/// Keeps the phases in order: a pick's come after all that went before.
void add(PickAndPlaceResult& result, PickResult picked) {
  std::vector<PhaseReport> phases = std::move(result.picked.phases);
  if (result.place) append(phases, result.place->phases);
  append(phases, picked.phases);
  result.picked = std::move(picked);
  result.picked.phases = std::move(phases);
}

/// Ends as a pick does that a fault has stopped: with what was done, and nothing known of the
/// object.
void end_by_fault(PickAndPlaceResult& result) {
  PickResult& picked = result.picked;
  if (result.place && result.place->fault) {
    picked.fault = result.place->fault;
    picked.failed_phase = result.place->failed_phase;
    append(picked.phases, result.place->phases);
  }
  if (!picked.fault) return;
  picked.held = false;
  picked.estimate = {};
  result.place.reset();
}

/// What the phase said that failed first, or else the one that found the goal.
std::string outcome_of(const PlaceResult& place) {
  const std::string name = place.failed_phase.empty() ? "plan-goal" : place.failed_phase;
  const auto phase = std::find_if(place.phases.begin(), place.phases.end(),
                                  [&](const PhaseReport& report) { return report.name == name; });
  return phase == place.phases.end() ? std::string(to_string(place.status)) : phase->outcome;
}

/// Whether the object lies where it can be picked again.
bool may_be_picked(const PlaceResult& place) {
  return was_put_back(place.status) || place.status == PlaceStatus::lost;
}

/// Whether another grasp of the same kind would not help.
bool needs_new_grasps(const PlaceResult& place) {
  return may_be_picked(place) &&
         (place.status == PlaceStatus::unreachable || place.other_stable_pose);
}

/// One pick-and-place, strategy by strategy.
class PlaceAttempts {
 public:
  PlaceAttempts(Executor& robot, const PickAndPlaceTask& task, const PhaseObserver& observer)
      : robot_(robot), task_(task), observer_(observer) {
    task_.pick = firm_enough(task.pick, task.target, task.place);
  }

  PickAndPlaceResult run() {
    try_strategies(place_strategy(task_.place.strategy));
    end_by_fault(result_);
    return std::move(result_);
  }

 private:
  void try_strategies(PlaceStrategy strategy) {
    if (strategy != PlaceStrategy::regrasp) {
      in_one_hold(strategy == PlaceStrategy::automatic);
      if (strategy == PlaceStrategy::wrist) result_.strategy.reason = "asked for";
      if (strategy == PlaceStrategy::fingers && !result_.strategy.reorientation) {
        result_.strategy.reason = "nothing for the fingers to turn: " + result_.strategy.reason;
      }
    }
    const bool held = result_.picked.held && result_.place;
    if (strategy == PlaceStrategy::regrasp) {
      by_regrasping("asked for");
    } else if (strategy == PlaceStrategy::automatic && held && needs_new_grasps(*result_.place)) {
      by_regrasping("not in one hold: " + outcome_of(*result_.place));
    }
  }

  /// @param may_regrasp  end where only that can help
  void in_one_hold(bool may_regrasp) {
    PickAndPlaceTask task = task_;
    for (int attempt = 0; attempt < task.place.picks; ++attempt) {
      task.seed = task_.seed + 1000003 * static_cast<std::uint64_t>(attempt);
      add(result_, pick(robot_, task.object, task.pick, task.seed, observer_));
      result_.strategy.strategy = PlaceStrategy::wrist;
      result_.strategy.reason = "the object was not held";
      if (!result_.picked.held) return;
      result_.place = place(robot_, task, result_.picked, observer_);
      result_.strategy.reason = "one hold: " + outcome_of(*result_.place);
      if (result_.place->reorientation) {
        result_.strategy.strategy = PlaceStrategy::fingers;
        result_.strategy.reason = result_.place->reorientation->why;
        result_.strategy.reorientation = result_.place->reorientation;
        task.place.strategy = to_string(PlaceStrategy::wrist);
      }
      if (!may_be_picked(*result_.place)) return;
      if (result_.place->put_aside) task.pick.fallen_at = result_.place->put_aside;
      if (result_.place->status == PlaceStatus::lost) {
        task.pick.fallen_at = result_.place->lost_at;
      }
      task_.pick.fallen_at = task.pick.fallen_at;
      if (may_regrasp && needs_new_grasps(*result_.place)) return;
    }
  }

  void by_regrasping(std::string reason) {
    PickAndPlaceTask task = task_;
    task.place.strategy = to_string(PlaceStrategy::regrasp);
    RegraspResult result = regrasp(robot_, task, observer_);
    result_.strategy.strategy = PlaceStrategy::regrasp;
    result_.strategy.reason = std::move(reason);
    result_.strategy.regrasp = result.status;
    for (RegraspRound& round : result.rounds) {
      add(result_, std::move(round.pick));
      result_.strategy.rounds.push_back({std::move(round.plan), std::nullopt});
      if (!round.place) continue;
      result_.strategy.rounds.back().place = round.place->status;
      result_.place = std::move(round.place);
    }
    if (!result_.place || task_.target.kind == PlaceTarget::Kind::spot) return;
    // Between the stable poses a transfer had a target of its own.
    result_.place->T_world_target = task_.target.T_world_object;
    if (result.status != RegraspStatus::done && result_.place->status == PlaceStatus::placed) {
      result_.place->status = PlaceStatus::under_way;
    }
  }

  Executor& robot_;
  PickAndPlaceTask task_;
  const PhaseObserver& observer_;
  PickAndPlaceResult result_;
};

}  // namespace

PickOptions firm_enough(const PickOptions& pick_options, const PlaceTarget& target,
                        const PlaceOptions& options) {
  PickOptions firm = pick_options;
  if (target.kind == PlaceTarget::Kind::pose) {
    firm.grasp.press_per_weight = std::max(firm.grasp.press_per_weight, options.turn_press);
  }
  return firm;
}

PickAndPlaceResult pick_and_place(Executor& robot, const PickAndPlaceTask& task,
                                  const PhaseObserver& observer) {
  return PlaceAttempts(robot, task, observer).run();
}

}  // namespace palpate::skills
