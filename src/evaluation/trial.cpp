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

/// Of the believed friction, that forces count on where the object may still move in the hand.
constexpr double kPlannedShare = 0.8;

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
  metrics.object_ok = candidates[objects.best] == &object;
  metrics.object_probability = objects.candidates[objects.best];
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
  options.grasp.friction = options.palpation.friction = friction;
  options.grasp.plan.friction = kPlannedShare * friction;
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
  options.fingers.reorient.friction = friction;
  options.transport.friction = options.regrasp.plan.grasp.friction = kPlannedShare * friction;
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
  skills::place_strategy(options);
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
  Trial trial;
  const auto target_from = [&](const simulation::Start& start) {
    return place_target(object.object(), options.place, seed,
                        static_cast<std::size_t>(start.stable_pose));
  };
  const planning::Fixture fixture =
      place_fixture(object.object(), options.place,
                    target_from(draw_start(object.object(), options.start, seed)));
  const skills::PickOptions pick_options = options.pick_options();
  simulation::WorldOptions world_options = options.world;
  world_options.biotacs = world_options.biotacs || options.touch.from_biotacs();
  const hand::FaultSchedule fault = options.fault.schedule(seed);
  world_options.second_object |= fault.fault == hand::InjectedFault::second_object;
  simulation::World world(object.object(), world_options, seed, fixture);
  trial.start = start_trial(world, object.object(), options.start, seed);
  const auto target = target_from(trial.start);

  Evaluator evaluator(world);
  Recorder recorder(sink, world);
  hand::FaultyHand faulty(world.hand(), fault, [&] {
    if (fault.fault == hand::InjectedFault::object_pushed) push_aside(world, seed);
  });
  std::optional<tactile::BiotacHand> biotac_hand;
  if (options.touch.from_biotacs()) {
    biotac_hand.emplace(faulty, world.hand_model(), tactile::shipped_biotac_inverse());
  }
  const simulation::SimulatedModels models(options.forward_model_options());
  hand::Hand& sensed = biotac_hand ? static_cast<hand::Hand&>(*biotac_hand) : faulty;
  skills::Executor robot(sensed, world.hand_model(), waiting_command(world.hand_model()),
                         {[&](const auto& reading, const auto& command) {
                            evaluator.observe(reading);
                            recorder.frame(reading, command);
                          },
                          [&](estimation::TouchEvent event) { recorder.event(event); },
                          [&](const auto& posterior) { recorder.posterior(posterior); }},
                         &models, {options.safety, std::move(stop)});
  skills::PhaseObserver observers = recorder.phases_and(observer);
  observers.on_picked = [&](const skills::PickResult& picked) {
    recorder.estimate(robot.time(), picked.estimate);
    trial.metrics =
        evaluator.metrics(picked, robot.log(), pick_options.lift, object.object().symmetries);
    identify(object, candidates, picked.objects, trial.metrics);
    if (observer.on_picked) observer.on_picked(picked);
  };
  observers.on_placed = [&](const skills::PlaceResult& placed) {
    const bool dropped = trial.place_metrics.dropped;  // before, on the way
    trial.place_metrics = evaluator.place_metrics(placed, *target, robot.log(), object.object());
    trial.place_metrics.dropped |= dropped;
    if (observer.on_placed) observer.on_placed(placed);
  };
  try {
    if (target) {
      skills::PickAndPlaceResult course = skills::pick_and_place(
          robot, {object, *target, fixture, pick_options, options.place_options(), seed},
          observers);
      trial.result = std::move(course.picked);
      trial.place = std::move(course.place);
      trial.strategy = std::move(course.strategy);
    } else {
      trial.result = skills::pick(robot, candidates, pick_options, seed, observers);
    }
  } catch (const std::exception&) {
    if (!world.diverged()) throw;
  }
  if (world.diverged()) return unstable(trial.start);
  trial.robot_seconds = robot.time();
  trial.events = trial_events(robot.log());
  trial.metrics.peak_load = faulty.peak_load();
  trial.metrics.peak_tip_force = faulty.peak_tip_force();
  if (trial.result.fault) forget_pose(trial.metrics);
  if (trial.place) recorder.placement(*trial.place, fixture);
  return trial;
}

}  // namespace palpate::evaluation
