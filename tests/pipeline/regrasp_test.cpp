// SPDX-License-Identifier: Apache-2.0
#include "palpate/pipeline/regrasp.hpp"

#include <gtest/gtest.h>

#include "palpate/pipeline/trial.hpp"

namespace palpate::pipeline {
namespace {

constexpr std::uint64_t kSeed = 7;

/// A hand that lets go of what it holds while told to.
class SlipperyHand : public hand::Hand {
 public:
  explicit SlipperyHand(hand::Hand& hand) : hand_(hand) {}

  const std::array<hand::Actuator, hand::kActuators>& actuators() const override {
    return hand_.actuators();
  }
  hand::HandReading step(const hand::HandCommand& command) override {
    hand::HandCommand told = command;
    if (lets_go) told.positions = open_posture(top_recipe());
    return hand_.step(told);
  }

  bool lets_go = false;

 private:
  hand::Hand& hand_;
};

TrialOptions quick_options() {
  TrialOptions options;
  options.pick.calibrate.touches = 0;
  options.pick.explore.touches = options.pick.explore.most_touches = 4;
  options.pick.lift.hold = 0.5;
  options.pick.locate.search.proposals = 20000;
  options.pick.locate.search.particles = 400;
  options.start.stance = 0;
  options.place.target = "0.15,0.1,0.5";
  options.place.certain = options.place.regrasp.certain_between = 0.3;
  return options;
}

/// A box whose regrasping goes wrong in the given phase of the first round.
struct Mishap {
  explicit Mishap(std::string_view phase, int rounds = 3) {
    const localization::ObjectModel box(geometry::load_known_object("box"));
    TrialOptions options = quick_options();
    options.place.regrasp.rounds = rounds;
    simulation::World world(box.object(), options.world, kSeed);
    world.reset(draw_start(box.object(), options.start, kSeed), waiting_command());
    SlipperyHand hand(world.hand());
    Robot robot(hand, world.hand_model(), waiting_command());
    int seen = 0;
    const PhaseObserver observer = {
        [&](std::string_view name, double) { hand.lets_go = name == phase && ++seen == 1; },
        [&](const PhaseReport&, double) { hand.lets_go = false; }};
    const auto target = place_target(box.object(), options.place, kSeed, 0);
    result = regrasp(robot, box, *target, {}, options.pick, options.place, kSeed, observer);
    if (!result.rounds.back().place) return;
    off = localization::pose_error(world.truth().T_world_object,
                                   result.rounds.back().place->T_world_target,
                                   box.object().symmetries);
  }
  RegraspResult result;
  localization::PoseError off{1, 1};  ///< from the last target
};

TEST(RegraspAfterALoss, LooksWhereTheObjectWasFeltLast) {
  const Mishap mishap("transport");
  ASSERT_GE(mishap.result.rounds.size(), 2u);
  const RegraspRound& first = mishap.result.rounds[0];
  ASSERT_TRUE(first.place);
  EXPECT_EQ(first.place->status, PlaceStatus::lost);
  EXPECT_GT(first.place->lost_at.norm(), 0.0);
  EXPECT_FALSE(first.pick.fallen);
  const RegraspRound& second = mishap.result.rounds[1];
  EXPECT_TRUE(second.pick.fallen);
  EXPECT_TRUE(second.pick.held);
  EXPECT_EQ(mishap.result.status, RegraspStatus::done);
  EXPECT_LT(mishap.off.translation, 0.03);
}

TEST(RegraspAfterALoss, EndsIfThatWasTheLastRound) {
  const Mishap mishap("transport", 1);
  ASSERT_EQ(mishap.result.rounds.size(), 1u);
  EXPECT_EQ(mishap.result.status, RegraspStatus::lost);
}

}  // namespace
}  // namespace palpate::pipeline
