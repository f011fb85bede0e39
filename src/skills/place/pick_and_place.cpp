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
void add(PickAndPlaceResult& course, PickResult picked) {
  std::vector<PhaseReport> phases = std::move(course.picked.phases);
  if (course.place) append(phases, course.place->phases);
  append(phases, picked.phases);
  course.picked = std::move(picked);
  course.picked.phases = std::move(phases);
}

/// Ends as a pick does that a fault has stopped: with what was done, and nothing known of the
/// object.
void end_by_fault(PickAndPlaceResult& course) {
  PickResult& picked = course.picked;
  if (course.place && course.place->fault) {
    picked.fault = course.place->fault;
    picked.failed_phase = course.place->failed_phase;
    append(picked.phases, course.place->phases);
  }
  if (!picked.fault) return;
  picked.held = false;
  picked.estimate = {};
  course.place.reset();
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

/// One course, step by step.
class PlaceAttempts {
 public:
  PlaceAttempts(Executor& robot, const PickAndPlaceTask& task, const PhaseObserver& observer)
      : robot_(robot), task_(task), observer_(observer) {
    task_.pick = firm_enough(task.pick, task.target, task.place);
  }

  PickAndPlaceResult run() {
    try_strategies(place_strategy(task_.place));
    end_by_fault(sequence_);
    return std::move(sequence_);
  }

 private:
  void try_strategies(PlaceStrategy strategy) {
    if (strategy != PlaceStrategy::regrasp) {
      in_one_hold(strategy == PlaceStrategy::automatic);
      if (strategy == PlaceStrategy::wrist) sequence_.strategy.reason = "asked for";
      if (strategy == PlaceStrategy::fingers && !sequence_.strategy.reorientation) {
        sequence_.strategy.reason = "nothing for the fingers to turn: " + sequence_.strategy.reason;
      }
    }
    const bool held = sequence_.picked.held && sequence_.place;
    if (strategy == PlaceStrategy::regrasp) {
      by_regrasping("asked for");
    } else if (strategy == PlaceStrategy::automatic && held && needs_new_grasps(*sequence_.place)) {
      by_regrasping("not in one hold: " + outcome_of(*sequence_.place));
    }
  }

  /// @param may_regrasp  end where only that can help
  void in_one_hold(bool may_regrasp) {
    PickAndPlaceTask task = task_;
    for (int attempt = 0; attempt < task.place.picks; ++attempt) {
      task.seed = task_.seed + 1000003 * static_cast<std::uint64_t>(attempt);
      add(sequence_, pick(robot_, task.object, task.pick, task.seed, observer_));
      sequence_.strategy.strategy = PlaceStrategy::wrist;
      sequence_.strategy.reason = "the object was not held";
      if (!sequence_.picked.held) return;
      sequence_.place = place(robot_, task, sequence_.picked, observer_);
      sequence_.strategy.reason = "one hold: " + outcome_of(*sequence_.place);
      if (sequence_.place->reorientation) {
        sequence_.strategy.strategy = PlaceStrategy::fingers;
        sequence_.strategy.reason = sequence_.place->reorientation->why;
        sequence_.strategy.reorientation = sequence_.place->reorientation;
        task.place.strategy = to_string(PlaceStrategy::wrist);
      }
      if (!may_be_picked(*sequence_.place)) return;
      if (sequence_.place->put_aside) task.pick.fallen_at = sequence_.place->put_aside;
      if (sequence_.place->status == PlaceStatus::lost) {
        task.pick.fallen_at = sequence_.place->lost_at;
      }
      task_.pick.fallen_at = task.pick.fallen_at;
      if (may_regrasp && needs_new_grasps(*sequence_.place)) return;
    }
  }

  void by_regrasping(std::string reason) {
    PickAndPlaceTask task = task_;
    task.place.strategy = to_string(PlaceStrategy::regrasp);
    RegraspResult result = regrasp(robot_, task, observer_);
    sequence_.strategy.strategy = PlaceStrategy::regrasp;
    sequence_.strategy.reason = std::move(reason);
    sequence_.strategy.regrasp = result.status;
    for (RegraspRound& round : result.rounds) {
      add(sequence_, std::move(round.pick));
      sequence_.strategy.rounds.push_back({std::move(round.plan), std::nullopt});
      if (!round.place) continue;
      sequence_.strategy.rounds.back().place = round.place->status;
      sequence_.place = std::move(round.place);
    }
    if (!sequence_.place || task_.target.kind == PlaceTarget::Kind::spot) return;
    // Between the stable poses a transfer had a target of its own.
    sequence_.place->T_world_target = task_.target.T_world_object;
    if (result.status != RegraspStatus::done && sequence_.place->status == PlaceStatus::placed) {
      sequence_.place->status = PlaceStatus::under_way;
    }
  }

  Executor& robot_;
  PickAndPlaceTask task_;
  const PhaseObserver& observer_;
  PickAndPlaceResult sequence_;
};

}  // namespace

PickAndPlaceResult pick_and_place(Executor& robot, const PickAndPlaceTask& task,
                                  const PhaseObserver& observer) {
  return PlaceAttempts(robot, task, observer).run();
}

}  // namespace palpate::skills
