// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "evaluation/quick_options.hpp"
#include "palpate/simulation/collision/forward_model.hpp"

namespace palpate::evaluation {

/// A hand whose fingers open, whatever they are commanded, while `lets_go`.
class SlipperyHand : public hand::Hand {
 public:
  /// @param open  where they then go, rad
  SlipperyHand(hand::Hand& hand, const hand::ActuatorVector& open) : hand_(hand), open_(open) {}

  hand::HandReading step(const hand::HandCommand& command) override {
    hand::HandCommand commanded = command;
    if (lets_go) commanded.positions = open_;
    return hand_.step(commanded);
  }

  bool lets_go = false;

 private:
  hand::Hand& hand_;
  hand::ActuatorVector open_;
};

/// A box (resting in its first stable pose) before a hand that lets go of it in the first
/// transport.
struct Mishap {
  static constexpr std::uint64_t kSeed = 7;

  /// Before the robot sees the hand, whose clock and mount must not jump.
  hand::Hand& started() {
    world.reset(draw_start(box.object(), options.start, kSeed),
                waiting_command(world.hand_model()));
    return world.hand();
  }
  /// Such a hand's joints do not follow.
  static skills::Safety lenient() {
    skills::Safety safety;
    safety.options.tracking_error = 10;
    return safety;
  }
  skills::PlaceTarget target() const {
    return *place_target(box.object(), options.place, kSeed, 0);
  }
  skills::PickAndPlaceTask task() const {
    return {box, target(), {}, options.pick, options.place, kSeed};
  }
  /// Of the object from where it was to be put, m.
  double off(const skills::PlaceResult& place) const {
    return (world.truth().T_world_object.translation() - place.T_world_target.translation()).norm();
  }

  geometry::ObjectModel box{geometry::load_known_object("box")};
  TrialOptions options = quick_place_options();
  simulation::World world{box.object(), {}, kSeed};
  SlipperyHand hand{started(), world.hand_model().postures.top.open};
  simulation::SimulatedModels models;
  skills::Executor robot{hand,    world.hand_model(), waiting_command(world.hand_model()), {},
                         &models, lenient()};
  int transports = 0;
  skills::PhaseObserver observer{
      [this](std::string_view phase, double) {
        hand.lets_go = phase == "transport" && ++transports == 1;
      },
      [this](const skills::PhaseReport&, double) { hand.lets_go = false; }};
};

}  // namespace palpate::evaluation
