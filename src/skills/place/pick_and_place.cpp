// SPDX-License-Identifier: Apache-2.0
#include "palpate/skills/place/pick_and_place.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <utility>

namespace palpate::skills {
namespace {

/// Keeps the phases in order: a pick's come after all that went before.
void add(PlaceCourse& course, PickResult picked) {
  std::vector<PhaseReport> phases = std::move(course.picked.phases);
  const auto append = [&](std::vector<PhaseReport>& more) {
    phases.insert(phases.end(), std::make_move_iterator(more.begin()),
                  std::make_move_iterator(more.end()));
    more.clear();
  };
  if (course.place) append(course.place->phases);
  append(picked.phases);
  course.picked = std::move(picked);
  course.picked.phases = std::move(phases);
}

/// What the phase said that failed first, or else the one that found the goal.
std::string outcome_of(const PlaceResult& place) {
  const std::string name = place.failed_phase.empty() ? "aim" : place.failed_phase;
  const auto phase = std::find_if(place.phases.begin(), place.phases.end(),
                                  [&](const PhaseReport& report) { return report.name == name; });
  return phase == place.phases.end() ? std::string(to_string(place.status)) : phase->outcome;
}

/// Whether the object lies where it can be picked anew.
bool may_be_picked(const PlaceResult& place) {
  return was_put_back(place.status) || place.status == PlaceStatus::lost;
}

/// Whether another grasp of the same kind would not help.
bool needs_new_grasps(const PlaceResult& place) {
  return may_be_picked(place) && (place.status == PlaceStatus::unreachable || place.other_stance);
}

/// One course, step by step.
class PlaceAttempts {
 public:
  PlaceAttempts(Robot& robot, const geometry::ObjectModel& object, const PlaceTarget& target,
                const planning::Fixture& fixture, const PickOptions& pick_options,
                const PlaceOptions& options, std::uint64_t seed, const PhaseObserver& observer)
      : robot_(robot),
        object_(object),
        target_(target),
        fixture_(fixture),
        pick_options_(firm_enough(pick_options, target, options)),
        options_(options),
        seed_(seed),
        observer_(observer) {}

  PlaceCourse run(PlaceMeans means) {
    if (means != PlaceMeans::regrasp) {
      in_one_hold(means == PlaceMeans::automatic);
      if (means == PlaceMeans::wrist) course_.means.reason = "asked for";
      if (means == PlaceMeans::fingers && !course_.means.turn) {
        course_.means.reason = "nothing for the fingers to turn: " + course_.means.reason;
      }
    }
    const bool held = course_.picked.held && course_.place;
    if (means == PlaceMeans::regrasp) {
      by_regrasping("asked for");
    } else if (means == PlaceMeans::automatic && held && needs_new_grasps(*course_.place)) {
      by_regrasping("not in one hold: " + outcome_of(*course_.place));
    }
    return std::move(course_);
  }

 private:
  /// @param may_regrasp  end where only that can help
  void in_one_hold(bool may_regrasp) {
    PlaceOptions options = options_;
    for (int attempt = 0; attempt < options_.picks; ++attempt) {
      const std::uint64_t seed = seed_ + 1000003 * static_cast<std::uint64_t>(attempt);
      add(course_, pick(robot_, object_, pick_options_, seed, observer_));
      course_.means.means = PlaceMeans::wrist;
      course_.means.reason = "the object was not held";
      if (!course_.picked.held) return;
      course_.place = place(robot_, object_, course_.picked, target_, fixture_, pick_options_,
                            options, seed, observer_);
      course_.means.reason = "one hold: " + outcome_of(*course_.place);
      if (course_.place->turn) {
        course_.means.means = PlaceMeans::fingers;
        course_.means.reason = course_.place->turn->why;
        course_.means.turn = course_.place->turn;
        options.means = to_string(PlaceMeans::wrist);
      }
      if (!may_be_picked(*course_.place)) return;
      if (course_.place->put_aside) pick_options_.fallen_at = course_.place->put_aside;
      if (course_.place->status == PlaceStatus::lost) {
        pick_options_.fallen_at = course_.place->lost_at;
      }
      if (may_regrasp && needs_new_grasps(*course_.place)) return;
    }
  }

  void by_regrasping(std::string reason) {
    PlaceOptions options = options_;
    options.means = to_string(PlaceMeans::regrasp);
    RegraspResult result =
        regrasp(robot_, object_, target_, fixture_, pick_options_, options, seed_, observer_);
    course_.means.means = PlaceMeans::regrasp;
    course_.means.reason = std::move(reason);
    course_.means.regrasp = result.status;
    for (RegraspRound& round : result.rounds) {
      add(course_, std::move(round.pick));
      course_.means.rounds.push_back({std::move(round.plan), std::nullopt});
      if (!round.place) continue;
      course_.means.rounds.back().place = round.place->status;
      course_.place = std::move(round.place);
    }
    if (!course_.place || target_.kind == PlaceTarget::Kind::spot) return;
    // Between the stances a transfer had a target of its own.
    course_.place->T_world_target = target_.T_world_object;
    if (result.status != RegraspStatus::done && course_.place->status == PlaceStatus::placed) {
      course_.place->status = PlaceStatus::under_way;
    }
  }

  Robot& robot_;
  const geometry::ObjectModel& object_;
  const PlaceTarget& target_;
  const planning::Fixture& fixture_;
  PickOptions pick_options_;
  const PlaceOptions& options_;
  std::uint64_t seed_;
  const PhaseObserver& observer_;
  PlaceCourse course_;
};

}  // namespace

PlaceCourse pick_and_place(Robot& robot, const geometry::ObjectModel& object,
                           const PlaceTarget& target, const planning::Fixture& fixture,
                           const PickOptions& pick_options, const PlaceOptions& options,
                           std::uint64_t seed, const PhaseObserver& observer) {
  return PlaceAttempts(robot, object, target, fixture, pick_options, options, seed, observer)
      .run(place_means(options));
}

}  // namespace palpate::skills
