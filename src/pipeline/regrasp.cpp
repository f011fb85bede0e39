// SPDX-License-Identifier: Apache-2.0
#include "palpate/pipeline/regrasp.hpp"

#include <algorithm>
#include <array>

namespace palpate::pipeline {
namespace {

constexpr std::array<std::string_view, 4> kStatusNames = {"done", "no_way", "not_held",
                                                          "out_of_rounds"};
constexpr double kGravity = 9.81;  // m/s^2

/// A course over several transfers.
class Transfers {
 public:
  Transfers(Robot& robot, const localization::ObjectModel& object,
            const Eigen::Isometry3d& T_world_target, const PickOptions& pick_options,
            const PlaceOptions& place_options, const RegraspCourseOptions& options,
            const PhaseObserver& observer)
      : robot_(robot),
        object_(object),
        target_(T_world_target),
        pick_options_(pick_options),
        place_options_(place_options),
        options_(options),
        observer_(observer),
        tool_(regrasp_tool(robot.model(), robot.actuators())) {
    const GraspOptions& grasp = pick_options.grasp;
    options_.plan.grasp.press =
        std::max(grasp.least_press, grasp.press_per_weight * object.object().mass * kGravity);
  }

  RegraspRound round(std::uint64_t seed) {
    RegraspRound round;
    round.pick =
        pick(robot_, object_, pick_options_, seed, observer_,
             [&](const localization::Posterior& resting) { return choose(resting, round); });
    if (!round.pick.held) return round;
    if (round.plan.transfers.empty()) round.plan = plan_in_hand(round.pick);
    // Where no way is known the target itself is tried: that puts the object back if it cannot be.
    PlaceTarget target;
    target.kind = PlaceTarget::Kind::pose;
    target.T_world_object = last(round) ? target_ : round.plan.transfers.front().T_world_to;
    PlaceOptions place_options = place_options_;
    if (!last(round)) place_options.certain = options_.certain_between;
    round.place = place(robot_, object_, round.pick, target, {}, pick_options_, place_options, seed,
                        observer_);
    return round;
  }

  /// Whether a round's transfer leads to the target.
  static bool last(const RegraspRound& round) { return round.plan.transfers.size() <= 1; }

 private:
  std::optional<GraspPlan> choose(const localization::Posterior& resting, RegraspRound& round) {
    if (resting.modes.empty()) return std::nullopt;
    round.plan = plan_regrasp(object_, robot_.model(), tool_, resting.modes.front().T_frame_object,
                              target_, options_.plan);
    if (!round.plan.found || round.plan.transfers.empty()) return std::nullopt;
    return round.plan.transfers.front().grasp;
  }

  /// With the grasp that the hand has.
  RegraspPlan plan_in_hand(const PickResult& picked) const {
    if (picked.estimate.posterior.modes.empty()) return {};
    const Holding holding{robot_.reading().base, plannable(robot_.reading().joints)};
    return plan_regrasp(object_, robot_.model(), tool_,
                        picked.estimate.posterior.modes.front().T_frame_object, target_,
                        options_.plan, holding);
  }

  Robot& robot_;
  const localization::ObjectModel& object_;
  Eigen::Isometry3d target_;
  const PickOptions& pick_options_;
  const PlaceOptions& place_options_;
  RegraspCourseOptions options_;
  const PhaseObserver& observer_;
  GraspTool tool_;
};

}  // namespace

std::string_view to_string(RegraspStatus status) {
  return kStatusNames[static_cast<std::size_t>(status)];
}

RegraspResult regrasp(Robot& robot, const localization::ObjectModel& object,
                      const Eigen::Isometry3d& T_world_target, const PickOptions& pick_options,
                      const PlaceOptions& place_options, const RegraspCourseOptions& options,
                      std::uint64_t seed, const PhaseObserver& observer) {
  Transfers transfers(robot, object, T_world_target, pick_options, place_options, options,
                      observer);
  RegraspResult result;
  for (int i = 0; i < options.rounds; ++i) {
    result.rounds.push_back(transfers.round(seed + 1000003 * static_cast<std::uint64_t>(i)));
    const RegraspRound& round = result.rounds.back();
    if (!round.pick.held) {
      result.status = RegraspStatus::not_held;
      return result;
    }
    if (round.place->status == PlaceStatus::placed && Transfers::last(round)) {
      result.status = RegraspStatus::done;
      return result;
    }
    // The object has been put back; another look may tell of a way.
    result.status = round.plan.found ? RegraspStatus::out_of_rounds : RegraspStatus::no_way;
  }
  return result;
}

}  // namespace palpate::pipeline
