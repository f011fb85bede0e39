// SPDX-License-Identifier: Apache-2.0
#include "palpate/skills/place/place.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <utility>

#include "palpate/core/angle.hpp"
#include "palpate/core/gravity.hpp"
#include "palpate/estimation/mean_load.hpp"
#include "palpate/hand/nearest_mount.hpp"
#include "skills/explore/extents.hpp"
#include "skills/last_contacts.hpp"
#include "skills/phase_sequence.hpp"
#include "skills/place/arm_reach.hpp"
#include "skills/place/standing.hpp"
#include "skills/place/turn_plan.hpp"
#include "skills/place/verify_phase.hpp"
#include "skills/release/release_phase.hpp"

namespace palpate::skills {
namespace {

constexpr const char* kPlace = "place";  // the phase that puts it at the target
constexpr double kUnknownHeight = 0.1;   // m, by which a turned hand may have to go lower

planning::CollisionOptions held_collisions() {
  planning::CollisionOptions options;
  options.self = false;  // the fingers of a closed hand touch each other
  return options;
}

/// A share that falls short of a limit is not to read as if it reached it.
double rounded_down(double share) { return std::floor(100 * share) / 100; }

/// A phase made of a function.
class ComputePhase : public Phase {
 public:
  ComputePhase(std::string_view name, std::function<PhaseEnd()> compute)
      : name_(name), compute_(std::move(compute)) {}
  std::string_view name() const override { return name_; }
  double time_limit() const override { return 1.0; }
  PhaseEnd run(Executor&, PickState&) override { return compute_(); }

 private:
  std::string_view name_;
  std::function<PhaseEnd()> compute_;
};

/// One placing, step by step.
class Placement {
 public:
  Placement(Executor& robot, const PickAndPlaceTask& task, const PickResult& picked,
            const PhaseObserver& observer)
      : robot_(robot),
        task_(task),
        object_(task.object.object()),
        options_(task.place),
        picked_(picked),
        scene_(robot.models().collision_checker(object_, robot.model(), held_collisions(),
                                                task.fixture)),
        sequence_(robot, state_, result_.phases, last_failed_, observer) {
    state_.estimate = picked.estimate;
    state_.clear_height = std::max(state_.clear_height, clear_height_over({&task.object}));
  }

  PlaceResult run() {
    result_.on_the_way = task_.target.on_the_way;
    try {
      execute();
      if (result_.status == PlaceStatus::lost) sequence_.run(ClearPhase());
    } catch (const SafetyStop& stop) {
      result_.status = PlaceStatus::stopped;
      result_.failed_phase = last_failed_;
      result_.fault = stop.report();
      result_.T_world_placed.reset();
    }
    return std::move(result_);
  }

 private:
  void execute();
  bool plan_goal();
  void expect_lean();
  std::string lean_text() const;
  GoalSearch search_goal(const HeldObject& held);
  bool reorient();
  bool plan_turned_goal();
  bool carry(std::string name);
  bool replan_goal();
  bool set_down(const PlaceGoal& goal, double wall, const LowerOptions& options, std::string name);
  bool withdraw();
  void put_back();
  bool fail(PlaceStatus status);
  double weight() const { return object_.mass * kGravity; }
  /// Whether what carries the hand ended the last phase.
  bool out_of_reach() const { return result_.phases.back().unreachable; }

  Executor& robot_;
  const PickAndPlaceTask& task_;
  const geometry::KnownObject& object_;
  const PlaceOptions& options_;
  const PickResult& picked_;
  std::unique_ptr<planning::CollisionChecker> scene_;
  PickState state_;
  PlaceResult result_;
  Eigen::Isometry3d T_flat_object_ = Eigen::Isometry3d::Identity();  // Standing::T_flat_object
  std::string last_failed_;
  PhaseSequence sequence_;
};

/// Remembers the first failure.
bool Placement::fail(PlaceStatus status) {
  result_.status = status;
  if (result_.failed_phase.empty()) result_.failed_phase = result_.phases.back().name;
  if (status == PlaceStatus::lost) {
    result_.lost_at = place_of_last_contacts(robot_).value_or(robot_.reading().mount.xyz.head<2>());
  }
  return false;
}

/// Decides whether the pose is known well enough, and where the mount has to go.
bool Placement::plan_goal() {
  const auto held =
      held_object(object_, picked_.estimate.posterior, robot_.log(),
                  robot_.log().at(estimation::TouchEvent::held), options_.same, picked_.fallen);
  PlaceStatus status = PlaceStatus::ambiguous;
  const bool ok = sequence_.run(ComputePhase("plan-goal", [&]() -> PhaseEnd {
    if (!held) return {false, "no pose of the held object"};
    result_.held = *held;
    result_.T_world_target = target_pose(task_.target, object_, held->found_stable_pose);
    if (held->certainty < options_.certain) {
      return {false, fmt::format("ambiguous: {:.2f} agree on where it would stand, {} required",
                                 rounded_down(held->certainty), options_.certain)};
    }
    status = PlaceStatus::unreachable;
    const GoalSearch search = search_goal(*held);
    result_.other_stable_pose = !search.same_stable_pose;
    expect_lean();
    result_.goal = search.goal;
    result_.reorientation = plan_in_hand_reorientation(
        place_strategy(options_.strategy),
        {robot_.reading().mount, result_.T_world_target, *held, search}, options_.fingers,
        [&](const HeldObject& turned) { return search_goal(turned).goal.has_value(); });
    if (!search.goal && !result_.reorientation) return {false, "unreachable: " + search.obstacle};
    return {true,
            fmt::format("{:.2f} agree; {} stable pose{}{}", held->certainty,
                        search.same_stable_pose ? "the same" : "another", lean_text(),
                        result_.reorientation ? "; fingers " + result_.reorientation->why : "")};
  }));
  return ok || fail(status);
}

/// How it will stand: as it did in the closed hand, if it is put down on the same side.
void Placement::expect_lean() {
  const double most = options_.same.angle;
  const auto& errors = task_.pick.estimation;
  if (task_.target.kind == PlaceTarget::Kind::fixture) {  // its walls keep it upright
    result_.upright = 1;
  } else if (result_.other_stable_pose || picked_.fallen) {
    const auto nearest = nearest_stable_pose(object_, result_.T_world_target.linear());
    result_.upright = upright_probability(task_.object, nearest.stable_pose, errors, most);
  } else {
    const Standing standing =
        as_it_stood(task_.object, robot_, result_.held.T_mount_object, errors, most);
    T_flat_object_ = standing.T_flat_object;
    result_.lean = standing.lean;
    result_.upright = standing.upright;
  }
  result_.certain = result_.held.certainty * result_.upright >= options_.certain;
}

std::string Placement::lean_text() const {
  if (result_.certain) return "";
  return fmt::format("; it leans by {:.0f} deg, upright with {:.2f}",
                     kDegreesPerRadian * result_.lean, rounded_down(result_.upright));
}

GoalSearch Placement::search_goal(const HeldObject& held) {
  return find_goal(object_, held, result_.T_world_target, robot_.reading(), *scene_, options_.goal,
                   [&](const PlaceGoal& goal) { return arm_obstacle(robot_, goal); });
}

/// Rotates the object by the fingers, then plans the goal again for the pose that the tracker
/// estimates.
bool Placement::reorient() {
  if (!result_.reorientation) return true;
  InHandReorientationOptions options = options_.fingers;
  options.reorient.errors = task_.pick.estimation.errors;
  const bool ok = sequence_.run(
      InHandReorientationPhase(options, task_.object, task_.seed, *result_.reorientation));
  if (result_.reorientation->lost) return fail(PlaceStatus::lost);
  if (!ok) fail(PlaceStatus::slipped);
  if (ok && plan_turned_goal()) return true;
  put_back();
  return false;
}

bool Placement::plan_turned_goal() {
  const bool ok = sequence_.run(ComputePhase("plan-turned-goal", [&]() -> PhaseEnd {
    const estimation::EventLog& log = robot_.log();
    const double certainty = result_.held.certainty;
    const auto held = held_object(object_, state_.estimate.posterior, log, log.readings.size() - 1,
                                  options_.same, true);
    if (!held) return {false, "no pose of the held object"};
    result_.held = *held;
    result_.held.certainty = certainty;
    const GoalSearch search = search_goal(result_.held);
    result_.goal = search.goal;
    if (!search.goal) return {false, "unreachable: " + search.obstacle};
    return {true,
            fmt::format("{:.1f} deg are left to the mount",
                        kDegreesPerRadian * share_of_fingers(robot_.reading().mount,
                                                             search.goal->mount, std::numbers::pi)
                                                .norm())};
  }));
  return ok || fail(PlaceStatus::unreachable);
}

/// Over the goal.
bool Placement::carry(std::string name) {
  TransportPhase transport(options_.transport, *scene_, *result_.goal, task_.seed, std::move(name));
  const bool there = sequence_.run(transport);
  if (result_.motion.samples.empty()) result_.motion = transport.motion();
  result_.goal = transport.goal();
  if (there) return true;
  const bool moved = transport.motion().status == planning::PlanStatus::ok;
  fail(transport.lost()           ? PlaceStatus::lost
       : moved && !out_of_reach() ? PlaceStatus::slipped
                                  : PlaceStatus::unreachable);
  if (!transport.lost()) put_back();
  return false;
}

/// Estimates the pose once more over the target, for the object has moved in the hand on the way:
/// gravity pulls elsewhere once the hand has turned. What comes of it only corrects the goal; where
/// it is less certain than what was known before, it is left alone. What the fingers have turned is
/// known from tracking them: the estimate counts on an object that has hardly moved in the hand.
bool Placement::replan_goal() {
  if (!options_.reestimate || result_.reorientation) return true;
  const estimation::EventLog& log = robot_.log();
  const std::size_t now = log.readings.size() - 1;
  const double least = std::min(options_.certain, result_.held.certainty);
  estimation::EstimationOptions options = task_.pick.estimation;
  if (result_.other_stable_pose) {
    options.motion_sigma *= options_.turned_motion;
    options.motion_angle_sigma *= options_.turned_motion;
  }
  std::optional<PlaceGoal> goal;
  PlaceStatus status = PlaceStatus::slipped;
  const bool ok = sequence_.run(ComputePhase("replan-goal", [&]() -> PhaseEnd {
    state_.estimate =
        estimation::PoseEstimator(task_.object, options, task_.seed).held(robot_.model(), log, now);
    const auto held =
        held_object(object_, state_.estimate.posterior, log, now, options_.same, picked_.fallen);
    if (!held || held->certainty < least) return {true, "nothing new"};
    const GoalSearch search = search_goal(*held);
    result_.held = *held;
    goal = search.goal;
    if (search.out_of_reach) status = PlaceStatus::unreachable;
    if (!goal) return {false, "unreachable, as it has moved in the hand: " + search.obstacle};
    const Eigen::Isometry3d by = goal->mount.pose() * result_.goal->mount.pose().inverse();
    return {true, fmt::format("the goal of the hand moves by {:.1f} mm and {:.1f} deg",
                              1e3 * (goal->mount.xyz - result_.goal->mount.xyz).norm(),
                              kDegreesPerRadian * Eigen::AngleAxisd(by.linear()).angle())};
  }));
  if (!ok) {
    fail(status);
    put_back();
  }
  if (!goal) return ok;
  result_.goal = goal;
  return carry("correct");
}

/// Sets down at the goal under the hand and lets go.
bool Placement::set_down(const PlaceGoal& goal, double wall, const LowerOptions& options,
                         std::string name) {
  const bool for_good = name == kPlace;
  SetDownPhase lower(options, goal, wall, std::move(name));
  const bool ok = sequence_.run(lower);
  if (for_good && lower.released()) {
    result_.T_world_placed = laid_flat(object_, lower.T_world_object()) * T_flat_object_;
  }
  if (ok) return withdraw();
  if (out_of_reach()) return fail(PlaceStatus::unreachable);
  return fail(lower.touchdown() == SetDownPhase::Touchdown::lost ? PlaceStatus::lost
                                                                 : PlaceStatus::refused);
}

bool Placement::withdraw() {
  return sequence_.run(WithdrawPhase(options_.withdraw, weight())) || fail(PlaceStatus::stuck);
}

/// Slowly all the way, for it is not known how far down the table is.
LowerOptions slow_lowering(LowerOptions options, double above) {
  options.near = std::max(options.near, above);
  options.beyond = kUnknownHeight;
  return options;
}

/// Back to where the object was lifted from: the one place that is known to be free and level.
void Placement::put_back() {
  const PlaceStatus reason = result_.status;
  const auto closed = robot_.log().at(estimation::TouchEvent::closed);
  PlaceGoal goal;
  goal.T_mount_object = result_.held.T_mount_object_flat;
  goal.mount = robot_.log().readings[*closed].mount;
  if (result_.reorientation && result_.reorientation->known) {
    const Eigen::Isometry3d T_world_object =
        laid_flat(object_, goal.mount.pose() * goal.T_mount_object);
    goal.mount = hand::nearest_mount(T_world_object * goal.T_mount_object.inverse(), goal.mount);
  }
  goal.above = goal.mount;
  goal.above.xyz.z() += options_.goal.rise;
  goal.T_world_object = goal.mount.pose() * goal.T_mount_object;
  TransportPhase carry(options_.transport, *scene_, goal, task_.seed, "carry-back");
  const bool there = sequence_.run(carry);
  goal = carry.goal();
  if (carry.lost()) {
    fail(PlaceStatus::lost);
    return;
  }
  LowerOptions lower = never_refused(options_.lower);
  if (!there) {  // setting down here is gentler than letting go up here
    const hand::MountPosition& here = robot_.reading().mount;
    lower = slow_lowering(lower, here.xyz.z() - goal.mount.xyz.z());
    goal.mount.xyz.head<2>() = here.xyz.head<2>();
    goal.mount.ypr = here.ypr;
  }
  const bool down = set_down(goal, 0, lower, "put-back");
  if (down && !there) {
    result_.put_aside = (goal.mount.pose() * goal.T_mount_object).translation().head<2>();
  }
  if (down) result_.status = reason;
  if (!down && result_.status != PlaceStatus::lost) result_.status = PlaceStatus::stuck;
}

void Placement::execute() {
  if (!plan_goal()) {
    put_back();
    return;
  }
  const bool slot = task_.target.kind == PlaceTarget::Kind::fixture;
  if (!reorient() || !carry("transport") || !replan_goal()) return;
  if (!set_down(*result_.goal, slot ? options_.fixture.height : 0, options_.lower, kPlace)) {
    if (was_put_back(result_.status)) put_back();
    return;
  }
  result_.status = PlaceStatus::placed;
  if (!options_.verify) return;
  state_.place = result_.T_world_placed->translation().head<2>();
  if (sequence_.run(VerifyPhase(task_.pick.height_probe, object_, *result_.T_world_placed))) return;
  if (!out_of_reach()) fail(PlaceStatus::missing);  // else the phase's outcome says why
}

}  // namespace

PlaceResult place(Executor& robot, const PickAndPlaceTask& task, const PickResult& picked,
                  const PhaseObserver& observer) {
  PlaceResult result = Placement(robot, task, picked, observer).run();
  if (observer.on_placed && !result.fault) observer.on_placed(result);
  return result;
}

}  // namespace palpate::skills
