// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>
#include <string>

#include "evaluation/quick_options.hpp"
#include "palpate/core/error.hpp"
#include "palpate/evaluation/evaluation.hpp"
#include "palpate/simulation/collision/forward_model.hpp"

namespace palpate::evaluation {
namespace {

constexpr std::uint64_t kSeed = 7;

const geometry::ObjectModel& box() {
  static const geometry::ObjectModel model(geometry::load_known_object("box"));
  return model;
}

TEST(PlaceTrial, PutsTheBoxDownAtItsTarget) {
  const auto trial = run_trial(box(), quick_place_options(), kSeed);
  ASSERT_TRUE(trial.result.held);
  ASSERT_TRUE(trial.place);
  EXPECT_EQ(trial.place->status, skills::PlaceStatus::placed) << trial.place->phases.back().outcome;
  EXPECT_FALSE(trial.place_metrics.dropped);
  EXPECT_EQ(trial.strategy.strategy, skills::PlaceStrategy::wrist);
  EXPECT_EQ(trial.strategy.reason.rfind("one hold: ", 0), 0u) << trial.strategy.reason;
  EXPECT_TRUE(trial.place->T_world_placed);
  EXPECT_LT(trial.place_metrics.error.translation, 0.03);
  const auto target = localization::pose_error(
      *trial.place->T_world_placed, trial.place_metrics.T_world_target, box().object().symmetries);
  EXPECT_LT(target.translation, 0.01);  // as far as the robot knows
}

/// Where the box ends, from its target, if it was estimated too far to one side when it was lifted.
double error_after_a_shift(const Eigen::Vector3d& shift, bool again) {
  TrialOptions options = quick_place_options();
  options.place.reestimate = again;
  options.place.verify = false;
  simulation::World world(box().object(), options.world, kSeed);
  world.reset(draw_start(box().object(), options.start, kSeed),
              waiting_command(world.hand_model()));
  const simulation::SimulatedModels models;
  skills::Executor robot(world.hand(), world.hand_model(), waiting_command(world.hand_model()), {},
                         &models);
  auto picked = skills::pick(robot, box(), options.pick, kSeed);
  EXPECT_TRUE(picked.held);
  for (auto& mode : picked.estimate.posterior.modes) mode.T_frame_object.pretranslate(shift);
  const auto target = place_target(box().object(), options.place, kSeed, 0);
  const auto placed =
      skills::place(robot, {box(), *target, {}, options.pick, options.place, kSeed}, picked);
  EXPECT_EQ(placed.status, skills::PlaceStatus::placed);
  return localization::pose_error(world.truth().T_world_object, placed.T_world_target,
                                  box().object().symmetries)
      .translation;
}

TEST(PlaceTrial, TheEstimateOverTheTargetMendsAWrongOne) {
  const Eigen::Vector3d shift(0.02, 0, 0);
  EXPECT_LT(error_after_a_shift(shift, true), error_after_a_shift(shift, false) - 0.005);
}

TEST(PlaceTrial, WhatMayBeTurnedOverIsHeldFirmer) {
  skills::PickOptions pick;
  pick.grasp.press_per_weight = 3;
  skills::PlaceOptions options;
  options.turn_press = 6;
  const auto press = [&](skills::PlaceTarget::Kind kind) {
    return skills::firm_enough(pick, {.kind = kind}, options).grasp.press_per_weight;
  };
  EXPECT_EQ(press(skills::PlaceTarget::Kind::pose), 6);
  EXPECT_EQ(press(skills::PlaceTarget::Kind::spot), 3);
  EXPECT_EQ(press(skills::PlaceTarget::Kind::fixture), 3);
  pick.grasp.press_per_weight = 9;  // never weaker than asked for
  EXPECT_EQ(press(skills::PlaceTarget::Kind::pose), 9);
}

TEST(PlaceTrial, WhatIsShakenOutOfTheHandIsDropped) {
  TrialOptions options = quick_place_options();
  options.place.strategy = "wrist";
  auto& limits = options.place.transport.plan.limits;
  limits.mount_speed = limits.turn_speed = 10;
  limits.mount_acceleration = limits.turn_acceleration = 100;
  // The robot's own limits forbid that.
  options.safety.mount_speed = options.safety.turn_speed = 10;
  options.safety.mount_acceleration = options.safety.turn_acceleration = 1000;
  options.safety.max_load = options.safety.load_range;
  options.place.transport.max_slip = 0.1;
  const auto trial = run_trial(box(), options, kSeed);
  ASSERT_TRUE(trial.place);
  EXPECT_TRUE(trial.place_metrics.dropped);
}

/// An object that was placed: within the tight bounds, or dropped.
Trial placed_trial(bool certain, bool tight) {
  Trial trial;
  trial.place.emplace();
  trial.place->certain = certain;
  trial.place_metrics.placed = trial.place_metrics.tight = tight;
  trial.place_metrics.wrong = certain && !tight;
  return trial;
}

TEST(PlaceTrial, WhatIsPlacedWithoutCertaintyDoesNotCountAmongTheCertain) {
  ObjectSummary summary;
  for (const bool certain : {true, false, false}) add_trial(placed_trial(certain, true), summary);
  add_trial(placed_trial(true, false), summary);
  EXPECT_EQ(summary.place.placed, 3u);
  EXPECT_EQ(summary.place.tight, 3u);
  EXPECT_EQ(summary.place.certain, 2u);
  EXPECT_EQ(summary.place.certain_placed, 1u);
  EXPECT_EQ(summary.place.certain_tight, 1u);
  EXPECT_EQ(summary.place.wrong, 1u);
}

TEST(PlaceTrial, WhatIsAmbiguousIsPutBackWhereItCameFrom) {
  TrialOptions options = quick_place_options();
  options.place.certain = 0.2504;  // hardly more than one of four poses has
  simulation::World world(box().object(), options.world, kSeed);
  world.reset(draw_start(box().object(), options.start, kSeed),
              waiting_command(world.hand_model()));
  const simulation::SimulatedModels models;
  skills::Executor robot(world.hand(), world.hand_model(), waiting_command(world.hand_model()), {},
                         &models);
  auto picked = skills::pick(robot, box(), options.pick, kSeed);
  ASSERT_TRUE(picked.held);
  const auto closed = *robot.log().at(estimation::TouchEvent::closed);
  const auto held = *robot.log().at(estimation::TouchEvent::held);
  const Eigen::Isometry3d lowered = robot.log().readings[closed].mount.pose() *
                                    robot.log().readings[held].mount.pose().inverse() *
                                    world.truth().T_world_object;
  // Four poses that disagree on the yaw.
  const localization::Mode mode = picked.estimate.posterior.modes.at(0);
  picked.estimate.posterior.modes.clear();
  for (const double yaw : {0.0, 0.4, 0.8, 1.2}) {
    localization::Mode turned = mode;
    turned.T_frame_object.linear() =
        Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ()) * mode.T_frame_object.linear();
    turned.weight = 0.25;
    picked.estimate.posterior.modes.push_back(turned);
  }
  const auto target = place_target(box().object(), options.place, kSeed, 0);
  const auto placed =
      skills::place(robot, {box(), *target, {}, options.pick, options.place, kSeed}, picked);
  EXPECT_EQ(placed.status, skills::PlaceStatus::ambiguous);
  EXPECT_EQ(placed.failed_phase, "plan-goal");
  ASSERT_FALSE(placed.phases.empty());
  double agree = 1, required = 0;
  const std::string& outcome = placed.phases.front().outcome;
  EXPECT_EQ(
      std::sscanf(outcome.c_str(), "ambiguous: %lf agree on where it would stand, %lf required",
                  &agree, &required),
      2)
      << outcome;
  EXPECT_LT(agree, required) << outcome;
  EXPECT_EQ(required, options.place.certain) << outcome;
  EXPECT_FALSE(placed.certain);
  EXPECT_EQ(placed.phases.back().name, "withdraw");
  EXPECT_EQ(placed.phases.back().status, skills::PhaseStatus::ok) << placed.phases.back().outcome;
  // It stands again where it was lifted: nothing fell or was thrown.
  const auto error =
      localization::pose_error(world.truth().T_world_object, lowered, box().object().symmetries);
  EXPECT_LT(error.translation, 0.02);
  EXPECT_LT(error.rotation, 0.1);
}

std::size_t count(const std::vector<skills::PhaseReport>& phases, const std::string& name) {
  return static_cast<std::size_t>(
      std::count_if(phases.begin(), phases.end(), [&](const auto& p) { return p.name == name; }));
}

TEST(PlaceTrial, GraspsAnewWhatOneHoldCannotStandUp) {
  const geometry::ObjectModel bottle(geometry::load_known_object("bottle"));
  TrialOptions options = quick_place_options();
  // Upright, which is none of the two stable poses that are likeliest.
  options.place.target = "1 0 0 0.15  0 1 0 0.05  0 0 1 0.0772  0 0 0 1";
  options.start.stable_pose = 1;
  // From this start the hand grasps it so that it would have to go into the table.
  const auto trial = run_trial(bottle, options, 1);
  ASSERT_TRUE(trial.result.held);
  ASSERT_TRUE(trial.place);
  EXPECT_EQ(trial.strategy.strategy, skills::PlaceStrategy::regrasp);
  EXPECT_NE(trial.strategy.reason.find("unreachable"), std::string::npos) << trial.strategy.reason;
  ASSERT_FALSE(trial.strategy.rounds.empty());
  EXPECT_FALSE(trial.strategy.rounds[0].plan.considered.empty());
  // The phases of all rounds, but those of the last placing are its own.
  const auto& before = trial.result.phases;
  EXPECT_EQ(count(before, "lift"), 1 + trial.strategy.rounds.size());
  EXPECT_EQ(count(before, "plan-goal"), trial.strategy.rounds.size());
  EXPECT_GE(count(before, "put-back"), 1u);
  EXPECT_EQ(count(trial.place->phases, "plan-goal"), 1u);
  EXPECT_EQ(trial.place->status, skills::PlaceStatus::placed) << trial.place->phases.back().outcome;
  EXPECT_EQ(trial.strategy.regrasp, skills::RegraspStatus::done);
  // Judged against the target itself: the bottle stands, and stands there.
  const Eigen::Matrix3d upright = trial.place_metrics.T_world_target.linear();
  EXPECT_TRUE(upright.isIdentity());
  EXPECT_LT(trial.place_metrics.error.translation, 0.03);
  EXPECT_LT(trial.place_metrics.error.rotation, 0.5);
}

TEST(PlaceTrial, TheFingersTakeAPartOfTheTurn) {
  TrialOptions options = quick_place_options();
  options.place.strategy = "fingers";
  options.place.fingers.reorient.sampling.samples = 8;
  const auto trial = run_trial(box(), options, 3);
  ASSERT_TRUE(trial.place);
  EXPECT_EQ(trial.strategy.strategy, skills::PlaceStrategy::fingers);
  ASSERT_TRUE(trial.strategy.reorientation);
  EXPECT_EQ(trial.strategy.reason, trial.strategy.reorientation->why);
  EXPECT_NEAR(trial.strategy.reorientation->asked.norm(), options.place.fingers.max, 1e-9);
  EXPECT_GT(trial.strategy.reorientation->mount_rotation,
            trial.strategy.reorientation->asked.norm());
  EXPECT_GT(trial.strategy.reorientation->result.rollouts, 0);
  EXPECT_EQ(count(trial.place->phases, "turn"), 1u);
  EXPECT_EQ(trial.place->status, skills::PlaceStatus::placed) << trial.place->phases.back().outcome;
  EXPECT_FALSE(trial.place_metrics.dropped);
  EXPECT_LT(trial.place_metrics.error.translation, 0.03);
}

TEST(PlaceTrial, WhatTheMountTurnsByLittleIsNoWorkForTheFingers) {
  TrialOptions options = quick_place_options();
  options.place.strategy = "fingers";
  options.place.fingers.min = 1.0;  // more than `max`: always too little
  const auto trial = run_trial(box(), options, kSeed);
  ASSERT_TRUE(trial.place);
  EXPECT_EQ(trial.strategy.strategy, skills::PlaceStrategy::wrist);
  EXPECT_FALSE(trial.strategy.reorientation);
  EXPECT_NE(trial.strategy.reason.find("nothing for the fingers"), std::string::npos)
      << trial.strategy.reason;
  EXPECT_EQ(count(trial.place->phases, "turn"), 0u);
}

TEST(PlaceTrial, MeansThatDoNotExistAreNamedBeforeAnythingMoves) {
  TrialOptions options = quick_place_options();
  options.place.strategy = "throw";
  bool moved = false;
  const skills::PhaseObserver observer = {[&](std::string_view, double) { moved = true; }, {}};
  try {
    run_trial(box(), options, kSeed, nullptr, observer);
    FAIL() << "expected BadInput";
  } catch (const BadInput& error) {
    EXPECT_NE(std::string(error.what()).find("throw"), std::string::npos) << error.what();
  }
  EXPECT_FALSE(moved);
}

TEST(PlaceTrial, ATargetThatCannotBeIsNamedBeforeAnythingMoves) {
  TrialOptions options = quick_place_options();
  bool moved = false;
  const skills::PhaseObserver observer = {[&](std::string_view, double) { moved = true; }, {}};
  for (const char* target : {"0.9,0,0", "fixture", "1 2 3 4"}) {
    options.place.target = target;
    options.place.fixture.tolerance = -0.002;
    EXPECT_THROW(run_trial(box(), options, kSeed, nullptr, observer), BadInput) << target;
  }
  options.place.target = "fixture";
  options.place.fixture = {.x = 0.12, .y = 0.0};  // where the box may stand at first
  try {
    run_trial(box(), options, kSeed, nullptr, observer);
    FAIL() << "expected BadInput";
  } catch (const BadInput& error) {
    EXPECT_NE(std::string(error.what()).find("may stand at first"), std::string::npos)
        << error.what();
  }
  EXPECT_FALSE(moved);
}

}  // namespace
}  // namespace palpate::evaluation
