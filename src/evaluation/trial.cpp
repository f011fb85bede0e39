// SPDX-License-Identifier: Apache-2.0
#include "palpate/evaluation/trial.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <exception>
#include <numbers>
#include <optional>
#include <utility>

#include "evaluation/evaluator.hpp"
#include "palpate/core/error.hpp"
#include "palpate/evaluation/recorder.hpp"
#include "palpate/simulation/collision/forward_model.hpp"
#include "palpate/tactile/biotac/contact_hand.hpp"

namespace palpate::evaluation {
namespace {

constexpr double kPush = 0.01, kPushSeconds = 0.1;  // m, s, of an object that is pushed aside

/// Farthest that any of an object is from its centroid, m.
double radius_of(const geometry::KnownObject& object) {
  double radius = 0;
  for (const auto& vertex : object.mesh.vertices) radius = std::max(radius, vertex.norm());
  return radius;
}

/// A trial in which the simulation became unstable: nothing that was sensed means anything.
Trial unstable(const simulation::Start& start) {
  Trial trial;
  trial.start = start;
  trial.result.failed_phase = kUnstable;
  return trial;
}

/// The object must not stand on the fixture before it is picked.
void check_clear(const planning::Fixture& fixture, const geometry::KnownObject& object,
                 const StartOptions& start) {
  const double room = radius_of(object) + std::numbers::sqrt2 * start.half_width();
  for (const auto& wall : fixture) {
    const Eigen::Vector3d origin =
        wall.T_world_box.inverse() * Eigen::Vector3d(start.x, start.y, 0);
    const Eigen::Vector3d beyond = (origin.cwiseAbs() - wall.half_extents).cwiseMax(0);
    const double apart = beyond.head<2>().norm();
    if (apart >= room) continue;
    throw BadInput(
        fmt::format("the fixture is where {} may stand at first: a wall {:.3f} m from its rough "
                    "place, {:.3f} m "
                    "are needed",
                    object.name, apart, room));
  }
}

void check_candidates(const geometry::ObjectModel& object, const estimation::Candidates& candidates,
                      const TrialOptions& options) {
  if (candidates.empty()) throw BadInput("a trial with 0 candidates");
  const bool known = candidates.size() == 1 && candidates.front() == &object;
  if (known || options.place.target.empty()) return;
  throw BadInput(fmt::format(
      "placing at {:?} needs one candidate, the object itself; {}", options.place.target,
      candidates.size() == 1
          ? fmt::format("{} is not {}", candidates.front()->object().name, object.object().name)
          : fmt::format("there are {}", candidates.size())));
}

/// The pose of another object is never right.
void identify(const geometry::ObjectModel& object, const estimation::Candidates& candidates,
              const localization::ObjectProbabilities& objects, TrialMetrics& metrics) {
  if (!metrics.has_pose) return;
  metrics.object_ok = geometry::is_same_shape(candidates[objects.best]->object(), object.object());
  metrics.object_probability = objects.probability;
  metrics.other_probability = objects.other;
  if (metrics.object_ok) return;
  metrics.pose_ok = metrics.pose_tight = metrics.covered = metrics.pose_ok_tracked = false;
  metrics.pose_ok_before_lift = metrics.pose_ok_before_probe = false;
  metrics.error.rotation = metrics.error_no_symmetry.rotation = std::numbers::pi;
}

/// After a fault, be it one of placing what was picked well, nothing is held or estimated.
void forget_pose(TrialMetrics& metrics) {
  metrics.lifted = metrics.has_pose = false;
  metrics.pose_ok = metrics.pose_tight = metrics.covered = false;
  metrics.status = localization::PoseStatus::no_pose;
  metrics.probability = 0;
}

/// To any side.
void push_aside(simulation::World& world, std::uint64_t seed) {
  const double side = RandomStream(seed, "push").uniform(-std::numbers::pi, std::numbers::pi);
  world.push_object(kPush * Eigen::Vector2d(std::cos(side), std::sin(side)), kPushSeconds);
}

}  // namespace

bool TouchOptions::from_biotacs() const {
  if (source != "solver" && source != "biotac") {
    throw BadInput(fmt::format("touch.source = {:?}: it is \"solver\" or \"biotac\"", source));
  }
  return source == "biotac";
}

TrialOptions TrialOptions::ideal() {
  TrialOptions options;
  options.start.uncertainty = 0.02;
  options.world = {};
  return options;
}

skills::PickOptions TrialOptions::pick_options() const {
  skills::PickOptions options = pick;
  options.set_friction(friction);
  options.estimation.place = {start.x, start.y};
  options.estimation.resting_half_width =
      std::max(options.estimation.resting_half_width, start.uncertainty + kPlaceMargin);
  options.calibrate.x += start.x;
  options.calibrate.y += start.y;
  if (touch.from_biotacs()) {
    options.estimation.errors.point_floor = touch.biotac_point;
    options.estimation.errors.normal_floor = touch.biotac_normal;
    options.estimation.false_contacts = touch.biotac_false;
  }
  return options;
}

skills::PlaceOptions TrialOptions::place_options() const {
  skills::PlaceOptions options = place;
  options.set_friction(friction);
  return options;
}

simulation::ForwardModelOptions TrialOptions::forward_model_options() const {
  simulation::ForwardModelOptions options = forward_model;
  options.hand_friction = friction;
  return options;
}

std::optional<skills::PlaceTarget> place_target(const geometry::KnownObject& object,
                                                const skills::PlaceOptions& options,
                                                std::uint64_t seed, std::size_t start_stable_pose) {
  skills::place_strategy(options.strategy);
  if (options.stable_pose >= 0 && options.target != "stable_pose") {
    throw BadInput(
        fmt::format("place.stable_pose = {} is of the target \"stable_pose\", not of {:?}",
                    options.stable_pose, options.target));
  }
  if (options.target.empty()) return std::nullopt;
  if (options.target == "stance") throw BadInput("the target stance is now stable_pose");
  if (options.target == "stable_pose") {
    return skills::stable_pose_target(object, start_stable_pose, options.stable_pose, options.reach,
                                      seed);
  }
  return skills::parse_target(options.target, object, options.fixture, options.reach, seed);
}

planning::Fixture place_fixture(const geometry::KnownObject& object,
                                const skills::PlaceOptions& options,
                                const std::optional<skills::PlaceTarget>& target) {
  if (!target || target->kind != skills::PlaceTarget::Kind::fixture) return {};
  return skills::make_fixture(object, options.fixture);
}

std::vector<TrialEvent> trial_events(const estimation::EventLog& log) {
  std::vector<TrialEvent> events;
  for (const auto& moment : log.moments) {
    events.push_back({moment.event, log.readings[moment.reading].time});
  }
  return events;
}

void check_trial(const geometry::KnownObject& object, const TrialOptions& options,
                 std::uint64_t seed) {
  static_cast<void>(options.touch.from_biotacs());
  static_cast<void>(options.fault.schedule(seed));
  const auto stable_pose =
      static_cast<std::size_t>(draw_start(object, options.start, seed).stable_pose);
  const auto target = place_target(object, options.place, seed, stable_pose);
  check_clear(place_fixture(object, options.place, target), object, options.start);
}

namespace {

std::optional<skills::PlaceTarget> target_from(const simulation::Start& start,
                                               const geometry::KnownObject& object,
                                               const TrialOptions& options, std::uint64_t seed) {
  return place_target(object, options.place, seed, static_cast<std::size_t>(start.stable_pose));
}

/// For the start that is drawn first; start_trial() may draw another.
planning::Fixture fixture_of(const geometry::KnownObject& object, const TrialOptions& options,
                             std::uint64_t seed) {
  const auto start = draw_start(object, options.start, seed);
  return place_fixture(object, options.place, target_from(start, object, options, seed));
}

simulation::WorldOptions world_options(const TrialOptions& options,
                                       const hand::FaultSchedule& fault) {
  simulation::WorldOptions world = options.world;
  world.biotacs = world.biotacs || options.touch.from_biotacs();
  world.second_object |= fault.fault == hand::InjectedFault::second_object;
  return world;
}

/// The world of a trial, what is between the robot and its hand, and who watches both.
class SimulatedTrial {
 public:
  /// All but the sink are kept by reference.
  SimulatedTrial(const geometry::ObjectModel& object, const estimation::Candidates& candidates,
                 const TrialOptions& options, std::uint64_t seed, recording::Sink* sink)
      : object_(object),
        candidates_(candidates),
        options_(options),
        seed_(seed),
        pick_options_(options.pick_options()),
        fixture_(fixture_of(object.object(), options, seed)),
        fault_(options.fault.schedule(seed)),
        world_(object.object(), world_options(options, fault_), seed, fixture_),
        recorder_(sink, world_) {
    trial_.start = start_trial(world_, object.object(), options.start, seed);
    target_ = target_from(trial_.start, object.object(), options, seed);
    if (options.touch.from_biotacs()) {
      biotac_hand_.emplace(faulty_, world_.hand_model(), tactile::shipped_biotac_inverse());
    }
  }

  Trial run(const skills::PhaseObserver& observer, std::stop_token stop) {
    const simulation::SimulatedModels models(options_.forward_model_options());
    hand::Hand& sensed = biotac_hand_ ? static_cast<hand::Hand&>(*biotac_hand_) : faulty_;
    skills::Executor robot(sensed, world_.hand_model(), waiting_command(world_.hand_model()),
                           executor_observer(), &models, {options_.safety, std::move(stop)});
    try {
      pick_and_place(robot, phase_observer(robot, observer));
    } catch (const std::exception&) {
      if (!world_.diverged()) throw;
    }
    if (world_.diverged()) return unstable(trial_.start);
    finish(robot);
    return std::move(trial_);
  }

 private:
  skills::Executor::Observer executor_observer() {
    return {[this](const auto& reading, const auto& command) {
              evaluator_.observe(reading);
              recorder_.frame(reading, command);
            },
            [this](estimation::TouchEvent event) { recorder_.event(event); },
            [this](const auto& posterior) { recorder_.posterior(posterior); }};
  }

  /// Records, evaluates what was picked and placed, and then calls the other one.
  skills::PhaseObserver phase_observer(const skills::Executor& robot,
                                       const skills::PhaseObserver& other) {
    skills::PhaseObserver all = recorder_.phases_and(other);
    all.on_picked = [&](const skills::PickResult& picked) {
      recorder_.estimate(robot.time(), picked.estimate);
      trial_.metrics =
          evaluator_.metrics(picked, robot.log(), pick_options_.lift, object_.object().symmetries);
      identify(object_, candidates_, picked.objects, trial_.metrics);
      if (other.on_picked) other.on_picked(picked);
    };
    all.on_placed = [&](const skills::PlaceResult& placed) {
      const bool dropped = trial_.place_metrics.dropped;  // before, on the way
      trial_.place_metrics =
          evaluator_.place_metrics(placed, *target_, robot.log(), object_.object());
      trial_.place_metrics.dropped |= dropped;
      if (other.on_placed) other.on_placed(placed);
    };
    return all;
  }

  void pick_and_place(skills::Executor& robot, const skills::PhaseObserver& observers) {
    if (!target_) {
      trial_.result = skills::pick(robot, candidates_, pick_options_, seed_, observers);
      return;
    }
    skills::PickAndPlaceResult outcome = skills::pick_and_place(
        robot, {object_, *target_, fixture_, pick_options_, options_.place_options(), seed_},
        observers);
    trial_.result = std::move(outcome.picked);
    trial_.place = std::move(outcome.place);
    trial_.strategy = std::move(outcome.strategy);
  }

  void finish(const skills::Executor& robot) {
    trial_.robot_seconds = robot.time();
    trial_.events = trial_events(robot.log());
    trial_.metrics.peak_load = faulty_.peak_load();
    trial_.metrics.peak_tip_force = faulty_.peak_tip_force();
    if (trial_.result.fault) forget_pose(trial_.metrics);
    if (trial_.place) recorder_.placement(*trial_.place, fixture_);
  }

  const geometry::ObjectModel& object_;
  const estimation::Candidates& candidates_;
  const TrialOptions& options_;
  std::uint64_t seed_;
  skills::PickOptions pick_options_;
  planning::Fixture fixture_;
  hand::FaultSchedule fault_;
  simulation::World world_;
  Trial trial_;
  std::optional<skills::PlaceTarget> target_;
  Evaluator evaluator_{world_};
  Recorder recorder_;
  hand::FaultyHand faulty_{world_.hand(), fault_, [this] {
                             if (fault_.fault == hand::InjectedFault::object_pushed) {
                               push_aside(world_, seed_);
                             }
                           }};
  std::optional<tactile::BiotacHand> biotac_hand_;
};

}  // namespace

Trial run_trial(const geometry::ObjectModel& object, const TrialOptions& options,
                std::uint64_t seed, recording::Sink* sink, const skills::PhaseObserver& observer,
                std::stop_token stop) {
  return run_trial(object, {&object}, options, seed, sink, observer, std::move(stop));
}

Trial run_trial(const geometry::ObjectModel& object, const estimation::Candidates& candidates,
                const TrialOptions& options, std::uint64_t seed, recording::Sink* sink,
                const skills::PhaseObserver& observer, std::stop_token stop) {
  check_candidates(object, candidates, options);
  check_trial(object.object(), options, seed);
  SimulatedTrial trial(object, candidates, options, seed, sink);
  return trial.run(observer, std::move(stop));
}

}  // namespace palpate::evaluation
