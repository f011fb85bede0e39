// SPDX-License-Identifier: Apache-2.0
#include "palpate/skills/place/regrasp.hpp"

#include <algorithm>
#include <array>

#include "palpate/skills/place/pick_and_place.hpp"
#include "skills/place/arm_reach.hpp"

namespace palpate::skills {
namespace {

constexpr std::array<std::string_view, 6> kStatusNames = {"done", "no_way",        "not_held",
                                                          "lost", "out_of_rounds", "stopped"};

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

/// A sequence of transfers.
class Transfers {
 public:
  Transfers(Executor& robot, const PickAndPlaceTask& task, const PhaseObserver& observer)
      : robot_(robot),
        task_(task),
        options_(task.place.regrasp),
        observer_(observer),
        tool_(regrasp_tool(robot.model())) {
    task_.pick = firm_enough(task.pick, turned_over(task.target), task.place);
    tool_.reaches = [this](const hand::MountPosition& mount) {
      return robot_.path_to({mount}).obstacle.empty();
    };
    tool_.releases = [this](const hand::MountPosition& mount) {
      return skills::releases(robot_, mount, task_.place.goal.rise);
    };
    options_.plan.grasp.press = pressure(task_.pick.grasp, task.object.object());
  }

  RegraspRound round(std::uint64_t seed) {
    RegraspRound round;
    round.pick =
        pick(robot_, task_.object, task_.pick, seed, observer_,
             [&](const localization::Posterior& resting) { return choose(resting, round); });
    if (!round.pick.held) return round;
    const bool otherwise_held = round.pick.regrasps > 0;  // than was planned
    if (otherwise_held || round.plan.transfers.empty()) round.plan = plan_in_hand(round.pick);
    // Where no way is known the target itself is tried: that puts the object back if it cannot be.
    PickAndPlaceTask task = task_;
    task.seed = seed;
    if (!last(round)) {
      task.target.kind = PlaceTarget::Kind::pose;
      task.target.on_the_way = true;
      task.target.T_world_object = round.plan.transfers.front().T_world_to;
      task.place.certain = options_.certain_between;
    }
    round.place = place(robot_, task, round.pick, observer_);
    remember(*round.place);
    return round;
  }

  /// Whether a round's transfer leads to the target.
  bool last(const RegraspRound& round) const {
    return task_.target.kind == PlaceTarget::Kind::spot || round.plan.transfers.size() <= 1;
  }

  /// Whether the object is somewhere on the table where it can be found by touch, and not yet at
  /// the target.
  bool goes_on(const RegraspRound& round) const {
    const PlaceStatus status = round.place->status;
    if (was_put_back(status) || status == PlaceStatus::lost) return true;
    return !last(round) && (status == PlaceStatus::placed || status == PlaceStatus::missing);
  }

  /// The sequence's status if this round is the last one.
  RegraspStatus end_of(const RegraspRound& round) const {
    if (round.pick.fault || (round.place && round.place->fault)) return RegraspStatus::stopped;
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
    if (place.put_aside) task_.pick.fallen_at = place.put_aside;
    if (was_put_back(place.status)) return;
    task_.pick.fallen_at.reset();
    if (place.status == PlaceStatus::placed) {
      task_.pick.estimation.place = place.T_world_placed->translation().head<2>();
    }
    if (place.status == PlaceStatus::lost) task_.pick.fallen_at = place.lost_at;
    if (place.status == PlaceStatus::missing && place.T_world_placed) {  // it fell over there
      task_.pick.fallen_at = place.T_world_placed->translation().head<2>();
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
    if (task_.target.kind == PlaceTarget::Kind::spot && round.plan.transfers.size() > 1) {
      return std::nullopt;  // the first transfer would end in a stable pose that was not asked for
    }
    return round.plan.transfers.front().grasp;
  }

  RegraspPlan plan(const Eigen::Isometry3d& now, const RegraspOptions& options) const {
    return plan_regrasp(task_.object, robot_.model(), tool_, now, goal(now), options);
  }

  /// With the grasp that the hand has.
  RegraspPlan plan_in_hand(const PickResult& picked) const {
    if (picked.estimate.posterior.modes.empty()) return {};
    const Holding holding{robot_.reading().mount,
                          plannable(robot_.model(), robot_.reading().joints)};
    const Eigen::Isometry3d& now = picked.estimate.posterior.modes.front().T_frame_object;
    return plan_regrasp(task_.object, robot_.model(), tool_, now, goal(now), options_.plan,
                        holding);
  }

  Eigen::Isometry3d goal(const Eigen::Isometry3d& T_world_object) const {
    return target_pose(
        task_.target, task_.object.object(),
        nearest_stable_pose(task_.object.object(), T_world_object.linear()).stable_pose);
  }

  Executor& robot_;
  PickAndPlaceTask task_;
  RegraspSequenceOptions options_;
  const PhaseObserver& observer_;
  GraspTool tool_;
};

}  // namespace

std::string_view to_string(RegraspStatus status) {
  return kStatusNames[static_cast<std::size_t>(status)];
}

RegraspResult regrasp(Executor& robot, const PickAndPlaceTask& task,
                      const PhaseObserver& observer) {
  Transfers transfers(robot, task, observer);
  RegraspResult result;
  int without_way = 0;  // rounds in a row
  for (int i = 0; i < task.place.regrasp.rounds && without_way < kWithoutWay; ++i) {
    result.rounds.push_back(transfers.round(task.seed + 1000003 * static_cast<std::uint64_t>(i)));
    const RegraspRound& round = result.rounds.back();
    result.status = transfers.end_of(round);
    if (!round.pick.held || !transfers.goes_on(round)) break;
    without_way = result.status == RegraspStatus::no_way ? without_way + 1 : 0;
  }
  return result;
}

}  // namespace palpate::skills
