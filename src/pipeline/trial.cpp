// SPDX-License-Identifier: Apache-2.0
#include "palpate/pipeline/trial.hpp"

#include <fmt/format.h>

#include <cmath>
#include <numbers>
#include <optional>

#include "palpate/core/error.hpp"
#include "palpate/pipeline/biotac_hand.hpp"
#include "palpate/pipeline/judge.hpp"
#include "palpate/pipeline/recorder.hpp"

namespace palpate::pipeline {

simulation::Start draw_start(const geometry::KnownObject& object, const StartOptions& options,
                             std::uint64_t seed) {
  const int count = static_cast<int>(object.stances.size());
  if (options.stance >= count) {
    throw BadInput(fmt::format("start.stance = {}: {} has the stances 0..{}", options.stance,
                               object.name, count - 1));
  }
  RandomStream random(seed, "start");
  simulation::Start start;
  double share = random.uniform();
  while (start.stance + 1 < count &&
         share >= object.stances[static_cast<std::size_t>(start.stance)].probability) {
    share -= object.stances[static_cast<std::size_t>(start.stance)].probability;
    ++start.stance;
  }
  if (options.stance >= 0) start.stance = options.stance;
  start.yaw = random.uniform(-std::numbers::pi, std::numbers::pi);
  start.xy = {random.uniform(-options.uncertainty, options.uncertainty),
              random.uniform(-options.uncertainty, options.uncertainty)};
  return start;
}

bool TouchOptions::from_biotacs() const {
  if (source != "solver" && source != "biotac") {
    throw BadInput(fmt::format("touch.source = {:?}: it is \"solver\" or \"biotac\"", source));
  }
  return source == "biotac";
}

PickOptions TrialOptions::pick_options() const {
  PickOptions options = pick;
  if (touch.from_biotacs()) {
    options.locate.errors.point_floor = touch.biotac_point;
    options.locate.errors.normal_floor = touch.biotac_normal;
  }
  return options;
}

std::optional<PlaceTarget> place_target(const geometry::KnownObject& object,
                                        const PlaceOptions& options, std::uint64_t seed) {
  if (options.target.empty()) return std::nullopt;
  return parse_target(options.target, object, options.fixture, options.reach, seed);
}

simulation::Fixture place_fixture(const geometry::KnownObject& object, const PlaceOptions& options,
                                  const std::optional<PlaceTarget>& target) {
  if (!target || target->kind != PlaceTarget::Kind::fixture) return {};
  return make_fixture(object, options.fixture);
}

hand::HandCommand waiting_command() {
  hand::HandCommand command;
  command.base.xyz = {0, 0, 0.34};
  return command;
}

Trial run_trial(const localization::ObjectModel& object, const TrialOptions& options,
                std::uint64_t seed, recording::Writer* writer, const PhaseObserver& observer) {
  Trial trial;
  trial.start = draw_start(object.object(), options.start, seed);
  const auto target = place_target(object.object(), options.place, seed);
  const simulation::Fixture fixture = place_fixture(object.object(), options.place, target);
  const PickOptions pick_options = options.pick_options();
  simulation::WorldOptions world_options = options.world;
  world_options.biotacs = world_options.biotacs || options.touch.from_biotacs();
  simulation::World world(object.object(), world_options, seed, fixture);
  world.reset(trial.start, waiting_command());

  Judge judge(world);
  Recorder recorder(writer, world);
  std::optional<BiotacHand> feeling;
  if (options.touch.from_biotacs()) {
    feeling.emplace(world.hand(), world.hand_model(), shipped_biotac_inverse());
  }
  Robot robot(feeling ? *feeling : world.hand(), world.hand_model(), waiting_command(),
              {[&](const auto& reading, const auto& command) {
                 judge.observe(reading);
                 recorder.frame(reading, command);
               },
               [&](Mark mark) { recorder.mark(mark); }});
  const PhaseObserver phases = recorder.phases_and(observer);
  std::vector<PhaseReport> earlier;  // phases of picks after which the object was put back
  for (int attempt = 0; attempt < options.place.picks; ++attempt) {
    trial.result = pick(robot, object, pick_options, seed, phases);
    recorder.estimate(robot.time(), trial.result.estimate);
    trial.judgement =
        judge.verdict(trial.result, robot.log(), pick_options.lift, object.object().symmetries);
    trial.result.phases.insert(trial.result.phases.begin(), earlier.begin(), earlier.end());
    if (!target || !trial.result.held) break;
    trial.place = place(robot, object, trial.result, *target, fixture, pick_options, options.place,
                        seed, phases);
    trial.place_judgement =
        judge.place_verdict(*trial.place, *target, robot.log(), object.object());
    if (!was_put_back(trial.place->status)) break;
    if (attempt + 1 == options.place.picks) break;
    earlier = trial.result.phases;
    earlier.insert(earlier.end(), trial.place->phases.begin(), trial.place->phases.end());
    trial.place->phases.clear();
  }
  if (trial.place) recorder.placement(trial.place->T_world_target, fixture);
  return trial;
}

}  // namespace palpate::pipeline
