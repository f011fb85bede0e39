// SPDX-License-Identifier: Apache-2.0
#include "palpate/skills/probe/palpation_phase.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "palpate/core/gravity.hpp"
#include "palpate/estimation/mean_load.hpp"
#include "palpate/localization/consensus.hpp"
#include "skills/motion/motion_constants.hpp"
#include "skills/probe/hidden_spin.hpp"
#include "skills/probe/probe_finger.hpp"
#include "skills/probe/probe_regrasp.hpp"

namespace palpate::skills {
namespace {

constexpr double kStepSeconds = 10;     // s that a touch takes at most, and back
constexpr double kRegraspSeconds = 14;  // s, of an object on the table
constexpr double kLiftSeconds = 6;      // s more, where it is to be put down and lifted again
constexpr double kMinWeight = 0.5;      // of the object's weight, that must still hang

/// Of the object since the hand last let go of it for good.
int regrasps_made(const estimation::EventLog& log) {
  return static_cast<int>(log.count(estimation::TouchEvent::opened));
}

GraspTool tool_of(const Executor& robot) {
  const hand::Preshape& preshape = robot.model().postures.top;
  const grasping::ClosingLaw law(robot.model(), kPlannedRate, preshape.closed);
  return {grasping::closing_trajectory(robot.model(), preshape.open, law), preshape.attitudes};
}

/// What could be done next, each with its expected gain.
struct Choices {
  std::optional<FingerProbes::Move> touch;
  std::optional<InformativeGrasp> grasp;

  /// Leaves the one with the most expected information a second.
  void keep_best(double min_gain_rate) {
    const auto rate = [&](const auto& choice) {
      return choice && choice->expected_gain.rate() >= min_gain_rate ? choice->expected_gain.rate()
                                                                     : -1.0;
    };
    const double best = std::max({rate(touch), rate(grasp), 0.0});
    if (rate(touch) < best) touch.reset();
    if (touch || rate(grasp) < best) grasp.reset();
  }
};

/// One run of the phase.
class Probing {
 public:
  Probing(Executor& robot, PickState& state, estimation::PoseEstimator& estimator,
          const PalpationOptions& options, const GraspOptions& grasp,
          estimation::TouchEvent instant)
      : robot_(robot),
        state_(state),
        estimator_(estimator),
        object_(estimator.object()),
        options_(options),
        grasp_(grasp),
        instant_(instant),
        fingers_(object_, options, pressure(grasp, object_.object())) {}

  PhaseEnd run(double last_start) {
    state_.next_grasp.reset();
    const double before = probability();
    while (holds_ && geometry::is_same_shape(object_.object(), estimator_.object().object()) &&
           probability() > 0 && probability() <= options_.certain && robot_.time() < last_start) {
      const Choices next = choices();
      if (next.grasp) state_.next_grasp = next.grasp->plan;
      if (!next.touch) break;
      touch(*next.touch);
    }
    return {!lost(), fmt::format("{} touch{}, probability {:.2f} -> {:.2f}{}", touches_,
                                 touches_ == 1 ? "" : "es", before, probability(),
                                 state_.next_grasp ? "; another grasp is more informative" : "")};
  }

 private:
  [[nodiscard]] bool hangs() const { return instant_ == estimation::TouchEvent::held; }
  [[nodiscard]] const localization::Posterior& posterior() const {
    return state_.estimate.posterior;
  }
  [[nodiscard]] double probability() const { return localization::best_probability(posterior()); }
  [[nodiscard]] bool lost() const {
    if (!hangs()) return !holds_;
    return estimation::mean_load(robot_.log()) < kMinWeight * object_.object().mass * kGravity;
  }

  /// The most informative of what has not been done too often yet.
  [[nodiscard]] Choices choices() const {
    Choices next;
    if (!hangs() && touches_ < options_.max) {
      next.touch = fingers_.choose(robot_, posterior(), RandomStream(estimator_.seed(), "probe"));
    }
    if (next.touch) {  // of draws, which also differ by each pose's own error
      auto& information = next.touch->expected_gain.information;
      information =
          std::min(information, localization::entropy(localization::poses_of(posterior()), {0, 0}));
    }
    if (worth_regrasping()) next.grasp = other_grasp();
    next.keep_best(options_.min_gain_rate);
    return next;
  }

  /// A hand that lacks a finger keeps what it holds, and so does one that holds something nearly
  /// round, which may roll away.
  [[nodiscard]] bool worth_regrasping() const {
    return robot_.trust().all_trusted() && regrasps_made(robot_.log()) < options_.regrasps &&
           probability_but_for_hidden_spin(object_, posterior(),
                                           estimator_.options().surface_sigma) <= options_.certain;
  }

  [[nodiscard]] std::optional<InformativeGrasp> other_grasp() const {
    const auto closed = robot_.log().at(estimation::TouchEvent::closed);
    if (!closed) return std::nullopt;
    InformativeGraspOptions options;
    options.plan.press = pressure(grasp_, object_.object());
    options.worst_cost = grasp_.max_wrench_residual;
    options.avoid = state_.tried_yaws;
    options.seconds = kRegraspSeconds + (hangs() ? kLiftSeconds : 0);
    localization::Posterior standing = posterior();
    if (hangs()) {  // where it comes to stand when the hand goes back to where it closed
      estimation::transform(
          robot_.log().readings[*closed].mount.pose() * robot_.reading().mount.pose().inverse(),
          standing);
    }
    return most_informative_grasp(object_, standing, tool_of(robot_), options);
  }

  /// Touches the object that stands on the table, and estimates the pose again.
  void touch(const FingerProbes::Move& move) {
    holds_ = fingers_.make(robot_, move);
    ++touches_;
    robot_.add_event(instant_);
    state_.estimate = estimator_.held(robot_.model(), robot_.log(), robot_.log().at(instant_));
  }

  Executor& robot_;
  PickState& state_;
  estimation::PoseEstimator& estimator_;
  const geometry::ObjectModel& object_;
  const PalpationOptions& options_;
  const GraspOptions& grasp_;
  estimation::TouchEvent instant_;
  FingerProbes fingers_;
  int touches_ = 0;
  bool holds_ = true;
};

}  // namespace

PhaseEnd PalpationPhase::run(Executor& robot, PickState& state) {
  Probing probing(robot, state, estimator_, options_, grasp_, instant_);
  return probing.run(robot.time() + time_limit() - kStepSeconds);
}

}  // namespace palpate::skills
