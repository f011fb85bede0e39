// SPDX-License-Identifier: Apache-2.0
#include "palpate/skills/pick.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <numbers>
#include <string>
#include <utility>

#include "palpate/core/gravity.hpp"
#include "palpate/estimation/mean_load.hpp"
#include "palpate/grasping/holdable.hpp"
#include "palpate/skills/explore/explore_phase.hpp"
#include "palpate/skills/grasp/track_phase.hpp"
#include "palpate/skills/probe/palpation_phase.hpp"
#include "skills/explore/extents.hpp"
#include "skills/explore/touch_test_phase.hpp"
#include "skills/grasp/pose_phase.hpp"
#include "skills/phase_sequence.hpp"
#include "skills/probe/hidden_spin.hpp"
#include "skills/probe/touch_table_phase.hpp"
#include "skills/release/release_phase.hpp"

namespace palpate::skills {
namespace {

constexpr double kLeft = 0.25;      // of the object's weight, in the hand: it has not been let go
constexpr double kSmoother = 0.65;  // of the friction that is believed, once an object has slipped
constexpr int kSlips = 2;           // attempts that do not count, for the grip gave way in time
constexpr double kMoreThanOthers = 0.5;  // probability of a pose that is worth being held
constexpr int kDoubts = 1;               // attempts that are given up because no pose is
constexpr double kHanging = 0.9;         // of the load that the mount may bear, while it moves
constexpr double kNextSide = 2 * std::numbers::pi / 3;  // rad between attempts

bool has(const estimation::EventLog& log, estimation::TouchEvent event) {
  return std::any_of(log.moments.begin(), log.moments.end(),
                     [event](const auto& moment) { return moment.event == event; });
}

/// Where that grasp does not hold, the phase chooses.
GraspChooser once(const grasping::GraspPlan& grasp) {
  return [next = std::optional(grasp)](const localization::Posterior&) mutable {
    return std::exchange(next, std::nullopt);
  };
}

constexpr double kLowest = 0.1;  // m, of the mount where an object is to be grasped

/// Why the mount cannot come to a place in any of the directions from which grasps are tried.
std::string place_obstacle(const Executor& robot, const Eigen::Vector2d& place) {
  hand::MountPosition there = robot.command().mount;
  there.xyz.head<2>() = place;
  if (std::string obstacle = robot.obstacle(there); !obstacle.empty()) return obstacle;
  const auto& attitudes = robot.model().postures.top.attitudes;
  if (attitudes.empty()) return {};
  std::string first;
  for (int side = 0; side < 3; ++side) {
    there.xyz.z() = kLowest;
    there.ypr << side * kNextSide, attitudes.front().pitch, attitudes.front().roll;
    const std::string obstacle = robot.obstacle(there);
    if (obstacle.empty()) return {};
    if (first.empty()) first = obstacle;
  }
  return first;
}

std::string why_not_holdable(const Executor& robot, const GraspOptions& grasp,
                             const geometry::ObjectModel& object) {
  const double weight = object.object().mass * kGravity, most = kHanging * robot.limits().max_load;
  if (weight > most) {
    return fmt::format("too heavy: it weighs {:.1f} N, and the mount may bear {:.0f} N", weight,
                       most);
  }
  return grasping::why_not_holdable(object, robot.model(), pressure(grasp, object.object()));
}

/// Why the hand can hold none of the candidates: of the first, that is.
std::string why_not_holdable(const Executor& robot, const GraspOptions& grasp,
                             const estimation::Candidates& candidates) {
  std::string first;
  for (const auto* candidate : candidates) {
    const std::string reason = why_not_holdable(robot, grasp, *candidate);
    if (reason.empty()) return {};
    if (first.empty()) first = reason;
  }
  return first;
}

/// Ends a pick before anything moves.
class Refusal final : public Phase {
 public:
  Refusal(std::string_view name, std::string reason) : name_(name), reason_(std::move(reason)) {}
  std::string_view name() const override { return name_; }
  double time_limit() const override { return 1; }
  PhaseEnd run(Executor& robot, PickState& state) override {
    static_cast<void>(robot), static_cast<void>(state);
    return {false, reason_};
  }

 private:
  std::string_view name_;
  std::string reason_;
};

/// Picks one object: the phases, and when which of them comes.
class Picking {
 public:
  Picking(Executor& robot, const estimation::Candidates& candidates, const PickOptions& options,
          std::uint64_t seed, const PhaseObserver& observer, const GraspChooser& choose)
      : robot_(robot),
        options_(options),
        seed_(seed),
        estimator_(candidates, options.estimation, seed),
        choose_(choose),
        sequence_(robot, state_, result_.phases, result_.failed_phase, observer) {
    state_.place = options.estimation.place;
    state_.clear_height = std::max(state_.clear_height, clear_height_over(candidates));
    if (!options.fallen_at) return;
    state_.place = *options.fallen_at;
    result_.fallen = true;
  }

  PickResult run() {
    try {
      run_phases();
    } catch (const SafetyStop& stop) {
      result_.fault = stop.report();
      result_.held = false;
      result_.estimate = {};
    }
    result_.limited_commands = robot_.limited_commands();
    result_.survived = robot_.survived();
    return std::move(result_);
  }

 private:
  void run_phases() {
    if (refused()) return;
    if (options_.calibrate.touches > 0 && robot_.model().kinematic_error > 0 &&
        !has(robot_.log(), estimation::TouchEvent::on_table)) {
      sequence_.run(CalibratePhase(options_.calibrate));
    }
    while (!result_.held && attempts_left()) {
      if (result_.attempts++ > 0) prepare_next_attempt();
      result_.held = attempt();
      if (result_.held && unknown() && doubts_ < kDoubts && robot_.trust().all_trusted() &&
          attempts_left()) {
        ++doubts_;
        result_.held = false;
        put_back();
      }
    }
    conclude();
  }

  /// Ends the pick where nothing can come of it.
  bool refused() {
    const std::string obstacle = place_obstacle(robot_, state_.place);
    robot_.require_running();
    if (!obstacle.empty()) {
      sequence_.run(Refusal("reach", "unreachable: " + obstacle));
      return true;
    }
    std::string reason = why_not_holdable(robot_, options_.grasp, estimator_.candidates());
    if (reason.empty()) return false;
    sequence_.run(Refusal("refuse", std::move(reason)));
    return true;
  }

  [[nodiscard]] bool attempts_left() const { return result_.attempts - slips_ < options_.attempts; }

  /// From another side.
  void prepare_next_attempt() {
    release();
    if (only_doubted()) --result_.attempts;
    result_.fallen = true;  // or a failed attempt has moved it
    state_.yaw += kNextSide;
  }

  void conclude() {
    result_.resting = state_.resting;
    if (result_.held) {
      result_.failed_phase.clear();
      result_.estimate = state_.estimate;
    } else if (estimation::mean_load(robot_.log()) > kLeft * weight() ||
               !robot_.trust().suspects().empty()) {
      release();       // nothing is left hanging
      only_doubted();  // an insensitive finger is named
    }
    result_.objects = estimator_.probabilities();
  }

  /// The most probable one.
  [[nodiscard]] const geometry::ObjectModel& object() const { return estimator_.object(); }
  [[nodiscard]] double weight() const { return object().object().mass * kGravity; }

  [[nodiscard]] double probability() const {
    return localization::best_probability(state_.estimate.posterior);
  }
  /// The same, where the spin of a nearly round object does not matter.
  [[nodiscard]] double but_for_spin() const {
    return probability_but_for_hidden_spin(object(), state_.estimate.posterior,
                                           options_.estimation.surface_sigma);
  }
  /// Whether no pose in the hand is more probable than all others.
  [[nodiscard]] bool unknown() const { return but_for_spin() < kMoreThanOthers; }

  /// What was known of the object's pose no longer holds.
  void release() {
    sequence_.run(ReleasePhase());
    state_.resting.reset();
    state_.next_grasp.reset();
  }

  /// Tests the fingers that are in doubt. @return whether all sense contact: the attempt, which the
  /// doubt ended, does not count
  bool only_doubted() {
    if (robot_.trust().suspects().empty()) return false;
    const std::size_t before = robot_.survived().size();
    sequence_.run(TouchTestPhase(options_.calibrate));
    return robot_.trust().suspects().empty() && robot_.survived().size() == before;
  }

  /// Touches, holds and lifts the object, from other sides too while that is informative about its
  /// pose.
  bool attempt() {
    if (!sequence_.run(HeightProbePhase(options_.height_probe, tallest(estimator_.candidates()))))
      return false;
    if (result_.fallen) robot_.add_event(estimation::TouchEvent::fallen);
    explore();
    GraspChooser choose = choose_;
    while (true) {
      if (!sequence_.run(GraspPhase(options_.grasp, object(), choose))) return false;
      estimate_closed();
      if (!state_.next_grasp && (!lift() || !estimate_held())) return false;
      if (!state_.next_grasp) return true;
      choose = once(*state_.next_grasp);
      if (!put_back()) return false;
    }
  }

  bool lift() {
    LiftPhase lift(options_.lift, weight());
    if (sequence_.run(lift)) return true;
    if (lift.gave_way() && slips_ < kSlips) ++slips_;
    doubt_friction();
    state_.estimate = {};  // it lies elsewhere now
    return false;
  }

  /// What slipped out of the hand is smoother than believed: later grasps count on less friction,
  /// and press harder.
  void doubt_friction() {
    options_.grasp.friction *= kSmoother;
    options_.grasp.plan.friction *= kSmoother;
    options_.palpation.friction *= kSmoother;
    options_.grasp.press_per_weight /= kSmoother;
  }

  /// Without a pose to aim by, the grasp goes for the rough place.
  void explore() {
    if (options_.explore.touches == 0) return;
    sequence_.run(ExplorePhase(estimator_, options_.explore));
  }

  void estimate_closed() {
    state_.next_grasp.reset();
    result_.before_probe.reset();
    result_.before_lift.reset();
    if (!options_.estimate_before_lift ||
        !sequence_.run(PosePhase(estimator_, estimation::TouchEvent::closed))) {
      return;
    }
    result_.before_probe = state_.estimate;
    if (but_for_spin() <= options_.palpation.doubtful) probe(estimation::TouchEvent::closed);
    result_.before_lift = state_.estimate;
  }

  /// @return whether the object is still held
  bool estimate_held() {
    result_.tracked.reset();
    if (result_.before_lift &&
        sequence_.run(TrackPhase(object(), options_.track, options_.estimation.errors, seed_))) {
      result_.tracked = state_.tracked;
    }
    if (!sequence_.run(PosePhase(estimator_))) return true;
    if (options_.palpation.table_touches > 0 &&
        !sequence_.run(TouchTablePhase(estimator_, options_.palpation, options_.lift.hold))) {
      doubt_friction();
      return false;
    }
    const bool in_doubt = probability() <= options_.palpation.certain;
    return !in_doubt || probe(estimation::TouchEvent::held);
  }

  /// @return whether the object is still held, as far as was sensed
  bool probe(estimation::TouchEvent instant) {
    if (options_.palpation.none()) return true;
    return sequence_.run(PalpationPhase(estimator_, options_.palpation, options_.grasp, instant));
  }

  /// Lets go of the object where it was grasped.
  bool put_back() {
    const auto& log = robot_.log();
    const LowerOptions lower = never_refused(options_.lower);
    bool ok = false;
    if (log.at(estimation::TouchEvent::held)) {
      PlaceGoal goal;
      goal.mount = log.readings[*log.at(estimation::TouchEvent::closed)].mount;
      ok = sequence_.run(SetDownPhase(lower, goal, 0, "put-down"));
    } else {
      ok = sequence_.run(OpenPhase(lower));
    }
    if (!ok ||
        !sequence_.run(WithdrawPhase(options_.withdraw, weight(), estimation::TouchEvent::opened)))
      return false;
    state_.resting = estimator_.resting(robot_.model(), robot_.log());
    if (state_.resting->modes.empty()) state_.resting.reset();
    ++result_.regrasps;
    return true;
  }

  Executor& robot_;
  PickOptions options_;
  std::uint64_t seed_;
  estimation::PoseEstimator estimator_;
  const GraspChooser& choose_;
  PickState state_;
  PickResult result_;
  PhaseSequence sequence_;
  int doubts_ = 0;  ///< attempts that ended as no pose was more probable than all others
  int slips_ = 0;   ///< attempts that ended as the grip gave way, and do not count
};

}  // namespace

PickResult pick(Executor& robot, const geometry::ObjectModel& object, const PickOptions& options,
                std::uint64_t seed, const PhaseObserver& observer, const GraspChooser& choose) {
  return pick(robot, estimation::Candidates{&object}, options, seed, observer, choose);
}

PickResult pick(Executor& robot, const estimation::Candidates& candidates,
                const PickOptions& options, std::uint64_t seed, const PhaseObserver& observer,
                const GraspChooser& choose) {
  PickResult result = Picking(robot, candidates, options, seed, observer, choose).run();
  if (observer.on_picked) observer.on_picked(result);
  return result;
}

}  // namespace palpate::skills
