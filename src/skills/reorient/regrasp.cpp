// SPDX-License-Identifier: Apache-2.0
#include "palpate/skills/reorient/regrasp.hpp"

#include <algorithm>
#include <array>

namespace palpate::skills {
namespace {

constexpr std::array<std::string_view, 5> kStatusNames = {"done", "no_way", "not_held", "lost",
                                                          "out_of_rounds"};

constexpr int kWithoutWay = 2;  // rounds that find no way before it is given up

/// The target as one that may ask for turning the object over: a slot may, too.
PlaceTarget turned_over(PlaceTarget target) {
  if (target.kind == PlaceTarget::Kind::fixture) target.kind = PlaceTarget::Kind::pose;
  return target;
}

/// Where no way is found: more directions of the hand, and a longer way.
RegraspOptions closer(RegraspOptions options) {
  options.grasp.yaws *= 2;
  ++options.max_transfers;
  return options;
}

/// A course over several transfers.
class Transfers {
 public:
  Transfers(Executor& robot, const geometry::ObjectModel& object, const PlaceTarget& target,
            const planning::Fixture& fixture, const PickOptions& pick_options,
            const PlaceOptions& options, const PhaseObserver& observer)
      : robot_(robot),
        object_(object),
        target_(target),
        fixture_(fixture),
        pick_options_(firm_enough(pick_options, turned_over(target), options)),
        place_options_(options),
        options_(options.regrasp),
        observer_(observer),
        tool_(regrasp_tool(robot.model())) {
    options_.plan.grasp.press = pressure(pick_options_.grasp, object.object());
  }

  RegraspRound round(std::uint64_t seed) {
    RegraspRound round;
    round.pick =
        pick(robot_, object_, pick_options_, seed, observer_,
             [&](const localization::Posterior& resting) { return choose(resting, round); });
    if (!round.pick.held) return round;
    const bool otherwise_held = round.pick.regrasps > 0;  // than was planned
    if (otherwise_held || round.plan.transfers.empty()) round.plan = plan_in_hand(round.pick);
    // Where no way is known the target itself is tried: that puts the object back if it cannot be.
    PlaceTarget target = target_;
    PlaceOptions options = place_options_;
    if (!last(round)) {
      target.kind = PlaceTarget::Kind::pose;
      target.on_the_way = true;
      target.T_world_object = round.plan.transfers.front().T_world_to;
      options.certain = options_.certain_between;
    }
    round.place = place(robot_, object_, round.pick, target, fixture_, pick_options_, options, seed,
                        observer_);
    remember(*round.place);
    return round;
  }

  /// Whether a round's transfer leads to the target.
  bool last(const RegraspRound& round) const {
    return target_.kind == PlaceTarget::Kind::spot || round.plan.transfers.size() <= 1;
  }

  /// Whether the object is somewhere on the table where it can be felt, and not yet at the target.
  bool goes_on(const RegraspRound& round) const {
    const PlaceStatus status = round.place->status;
    if (was_put_back(status) || status == PlaceStatus::lost) return true;
    return !last(round) && (status == PlaceStatus::placed || status == PlaceStatus::missing);
  }

  /// The course's status if this round is the last one.
  RegraspStatus end_of(const RegraspRound& round) const {
    if (!round.pick.held) return RegraspStatus::not_held;
    if (round.place->status == PlaceStatus::lost) return RegraspStatus::lost;
    if (goes_on(round)) {
      return round.plan.found ? RegraspStatus::out_of_rounds : RegraspStatus::no_way;
    }
    return round.place->status == PlaceStatus::placed ? RegraspStatus::done : RegraspStatus::lost;
  }

 private:
  /// Where the object is to be looked for next: what was put back lies where it was.
  void remember(const PlaceResult& place) {
    if (place.put_aside) pick_options_.fallen_at = place.put_aside;
    if (was_put_back(place.status)) return;
    pick_options_.fallen_at.reset();
    if (place.status == PlaceStatus::lost) pick_options_.fallen_at = place.lost_at;
    if (place.status == PlaceStatus::missing && place.T_world_placed) {  // it fell over there
      pick_options_.fallen_at = place.T_world_placed->translation().head<2>();
    }
  }

  std::optional<grasping::GraspPlan> choose(const localization::Posterior& resting,
                                            RegraspRound& round) {
    if (resting.modes.empty()) return std::nullopt;
    const Eigen::Isometry3d& now = resting.modes.front().T_frame_object;
    // Asked again after a closing out of balance, of an object that lies as it lay.
    const bool known = !round.plan.transfers.empty() &&
                       round.plan.transfers.front().T_world_from.matrix() == now.matrix();
    if (!known) {
      round.plan = plan(now, options_.plan);
      if (!round.plan.found) round.plan = plan(now, closer(options_.plan));
    }
    if (!round.plan.found || round.plan.transfers.empty()) return std::nullopt;
    if (target_.kind == PlaceTarget::Kind::spot && round.plan.transfers.size() > 1) {
      return std::nullopt;  // the first transfer would end in a stable pose that was not asked for
    }
    return round.plan.transfers.front().grasp;
  }

  RegraspPlan plan(const Eigen::Isometry3d& now, const RegraspOptions& options) const {
    return plan_regrasp(object_, robot_.model(), tool_, now, goal(now), options);
  }

  /// With the grasp that the hand has.
  RegraspPlan plan_in_hand(const PickResult& picked) const {
    if (picked.estimate.posterior.modes.empty()) return {};
    const Holding holding{robot_.reading().base,
                          plannable(robot_.model(), robot_.reading().joints)};
    const Eigen::Isometry3d& now = picked.estimate.posterior.modes.front().T_frame_object;
    return plan_regrasp(object_, robot_.model(), tool_, now, goal(now), options_.plan, holding);
  }

  Eigen::Isometry3d goal(const Eigen::Isometry3d& T_world_object) const {
    return target_pose(target_, object_.object(),
                       nearest_stable_pose(object_.object(), T_world_object.linear()).stable_pose);
  }

  Executor& robot_;
  const geometry::ObjectModel& object_;
  const PlaceTarget& target_;
  const planning::Fixture& fixture_;
  PickOptions pick_options_;
  const PlaceOptions& place_options_;
  RegraspSequenceOptions options_;
  const PhaseObserver& observer_;
  GraspTool tool_;
};

}  // namespace

std::string_view to_string(RegraspStatus status) {
  return kStatusNames[static_cast<std::size_t>(status)];
}

RegraspResult regrasp(Executor& robot, const geometry::ObjectModel& object,
                      const PlaceTarget& target, const planning::Fixture& fixture,
                      const PickOptions& pick_options, const PlaceOptions& options,
                      std::uint64_t seed, const PhaseObserver& observer) {
  Transfers transfers(robot, object, target, fixture, pick_options, options, observer);
  RegraspResult result;
  int without_way = 0;  // rounds in a row
  for (int i = 0; i < options.regrasp.rounds && without_way < kWithoutWay; ++i) {
    result.rounds.push_back(transfers.round(seed + 1000003 * static_cast<std::uint64_t>(i)));
    const RegraspRound& round = result.rounds.back();
    result.status = transfers.end_of(round);
    if (!round.pick.held || !transfers.goes_on(round)) break;
    without_way = result.status == RegraspStatus::no_way ? without_way + 1 : 0;
  }
  return result;
}

}  // namespace palpate::skills
