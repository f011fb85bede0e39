// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <string>

#include "evaluation/quick_options.hpp"
#include "palpate/simulation/collision/forward_model.hpp"

namespace palpate::evaluation {
namespace {

constexpr std::uint64_t kArmSeed = 7;

/// A hand on an arm that goes nowhere while it is `blocked`.
class BlockedHand : public hand::Hand {
 public:
  explicit BlockedHand(hand::Hand& hand) : hand_(hand) {}
  hand::HandReading step(const hand::HandCommand& command) override { return hand_.step(command); }
  hand::PathFeasibility check_path(std::span<const hand::MountPosition>) const override {
    if (blocked) return {.obstacle = "the hand would meet shoulder_link"};
    return {};
  }
  bool blocked = false;

 private:
  hand::Hand& hand_;
};

/// A box that is placed by an arm which cannot move in one phase.
skills::PlaceResult place_blocked_in(std::string_view blocked_phase) {
  const geometry::ObjectModel box(geometry::load_known_object("box"));
  const TrialOptions options = quick_place_options();
  simulation::World world(box.object(), options.world, kArmSeed);
  world.reset(draw_start(box.object(), options.start, kArmSeed),
              waiting_command(world.hand_model()));
  BlockedHand hand(world.hand());
  const simulation::SimulatedModels models;
  skills::Executor robot(hand, world.hand_model(), waiting_command(world.hand_model()), {},
                         &models);
  const auto picked = skills::pick(robot, box, options.pick, kArmSeed);
  EXPECT_TRUE(picked.held);
  const auto target = place_target(box.object(), options.place, kArmSeed, 0);
  const skills::PhaseObserver observer{
      [&](std::string_view phase, double) { hand.blocked = phase == blocked_phase; },
      [&](const skills::PhaseReport&, double) { hand.blocked = false; },
      {},
      {}};
  return skills::place(robot, {box, *target, {}, options.pick, options.place, kArmSeed}, picked,
                       observer);
}

TEST(UnreachablePlace, WhatTheArmCannotCarryOrSetDownIsPutBackAsUnreachable) {
  for (const char* phase : {"transport", "place"}) {
    const skills::PlaceResult place = place_blocked_in(phase);
    EXPECT_EQ(place.status, skills::PlaceStatus::unreachable) << phase;
    EXPECT_EQ(place.failed_phase, phase);
    EXPECT_EQ(place.phases.back().name, "withdraw") << phase;  // after the put-back
    EXPECT_EQ(place.phases.back().status, skills::PhaseStatus::ok) << phase;
  }
}

TEST(UnreachablePlace, WhatTheArmCannotVerifyIsPlacedAllTheSame) {
  const skills::PlaceResult place = place_blocked_in("verify");
  EXPECT_EQ(place.status, skills::PlaceStatus::placed);
  EXPECT_EQ(place.failed_phase, "");
  ASSERT_EQ(place.phases.back().name, "verify");
  EXPECT_TRUE(place.phases.back().unreachable);
  EXPECT_EQ(place.phases.back().outcome, "unreachable: the hand would meet shoulder_link");
}

}  // namespace
}  // namespace palpate::evaluation
