// SPDX-License-Identifier: Apache-2.0
#include "palpate/skills/grasp/lift_phase.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <string>

#include "hand/fake_hand.hpp"
#include "palpate/core/assets.hpp"
#include "palpate/core/random.hpp"
#include "palpate/simulation/hand/load_hand.hpp"
#include "palpate/simulation/world/world.hpp"

namespace palpate::skills {
namespace {

constexpr double kWeight = 3.0;  // N

/// A hand that holds an object with all fingertips, but for what a script changes of it `since` the
/// hold began (s; negative before).
struct Lifting {
  using Script = std::function<void(hand::HandReading&, double since)>;

  explicit Lifting(Script script = {})
      : hand([this, script = std::move(script)](hand::HandReading& reading) {
          reading.mount_force.z() = kWeight;
          for (auto& tip : reading.contacts) tip.push_back({{0, 0, 0.02}, {0, 1, 0}, {0, -1, 0}});
          if (script) script(reading, reading.time - begin_hold());
        }),
        robot(hand, model, hand::resting_command()) {}

  double begin_hold() const {
    return options.trial_height / options.trial_speed +
           (options.height - options.trial_height) / options.speed + options.settle;
  }
  PhaseReport lift() {
    LiftPhase phase(options, kWeight);
    return run_phase(phase, robot, state);
  }

  LiftOptions options;
  hand::Description model =
      hand::with_soft_actuators(simulation::load_shadow_hand(asset("shadow_hand/right_hand.xml")));
  PickState state;
  hand::FakeHand hand;
  Executor robot;
};

/// What is wrong with a hold that is not good, as the outcome names it.
void expect_failed(Lifting& lifting, const std::string& why) {
  const auto report = lifting.lift();
  EXPECT_EQ(report.status, PhaseStatus::failed) << report.outcome;
  EXPECT_EQ(report.outcome.substr(0, report.outcome.find(':')), why);
}

TEST(LiftPhase, HoldsWhatHangsInTheHand) {
  Lifting lifting;
  const auto report = lifting.lift();
  EXPECT_EQ(report.status, PhaseStatus::ok) << report.outcome;
  EXPECT_EQ(report.outcome.substr(0, 5), "held:");
  EXPECT_NEAR(lifting.robot.command().mount.xyz.z(), lifting.options.height, 1e-12);
  EXPECT_NEAR(lifting.state.held_load, kWeight, 1e-12);
  EXPECT_EQ(lifting.robot.log().at(estimation::TouchEvent::held),
            lifting.robot.log().readings.size() - 1);
}

/// Fingertips that slide off as the hand rises: nothing of their forces is left at a height, m.
Lifting::Script sliding_off(double height) {
  return [height](hand::HandReading& reading, double) {
    const double left = std::clamp(1 - reading.mount.xyz.z() / height, 0.0, 1.0);
    for (auto& tip : reading.contacts) tip[0].f *= left;
  };
}

TEST(LiftPhase, AGripThatGivesWayIsNoticedWhileTheObjectStandsOnTheTable) {
  double highest = 0;
  Lifting watched([&](hand::HandReading& reading, double since) {
    sliding_off(0.02)(reading, since);
    highest = std::max(highest, reading.mount.xyz.z());
  });
  LiftPhase phase(watched.options, kWeight);
  const auto report = run_phase(phase, watched.robot, watched.state);
  EXPECT_EQ(report.status, PhaseStatus::failed);
  EXPECT_TRUE(phase.gave_way()) << report.outcome;
  EXPECT_GT(highest, 0.003);
  EXPECT_LT(highest, watched.options.trial_height);
  EXPECT_NEAR(watched.robot.command().mount.xyz.z(), 0, 1e-12) << "it is down again";
  EXPECT_FALSE(watched.robot.log().at(estimation::TouchEvent::held));
}

TEST(LiftPhase, WhatPressedTheObjectOnTheTableIsNotLost) {
  const auto lifting = [](double onto_table) {
    return Lifting([onto_table](hand::HandReading& reading, double) {
      const bool up = reading.mount.xyz.z() > 0.001;
      reading.mount_force.z() = up ? kWeight : -onto_table;
      if (!up) return;
      reading.contacts[0][0].f *= 0.0;  // of five fingertips of 1 N
      reading.contacts[1][0].f *= 0.5;
    });
  };
  Lifting pressed = lifting(1.5);
  EXPECT_EQ(pressed.lift().status, PhaseStatus::ok);
  Lifting beside = lifting(0);
  expect_failed(beside, "the grip gives way; back on the table");
}

TEST(LiftPhase, AGripThatSlidesOffIsLostHoweverHardTheHandPressedOnTheTable) {
  Lifting lifting([](hand::HandReading& reading, double since) {
    sliding_off(0.01)(reading, since);
    if (reading.mount.xyz.z() < 0.001) reading.mount_force.z() = -20;
  });
  expect_failed(lifting, "the grip gives way; back on the table");
}

TEST(LiftPhase, NoticesThatTooLittleHangs) {
  Lifting light(
      [](hand::HandReading& reading, double) { reading.mount_force.z() = 0.49 * kWeight; });
  expect_failed(light, "lost");
  Lifting enough(
      [](hand::HandReading& reading, double) { reading.mount_force.z() = 0.51 * kWeight; });
  EXPECT_EQ(enough.lift().status, PhaseStatus::ok);
}

/// Leaves the first fingers their contacts from late in the hold on, and takes the others'.
Lifting::Script touching_at_the_end(std::size_t fingers) {
  return [fingers](hand::HandReading& reading, double since) {
    if (since < 0.5) return;
    for (std::size_t i = fingers; i < reading.contacts.size(); ++i) reading.contacts[i].clear();
  };
}

TEST(LiftPhase, NoticesContactsThatAreLostWhateverTheMountWeighs) {
  for (const std::size_t fingers : {0, 1}) {
    Lifting lifting(touching_at_the_end(fingers));
    expect_failed(lifting, "contacts lost");
  }
  Lifting lost(touching_at_the_end(0));
  LiftPhase phase(lost.options, kWeight);
  EXPECT_EQ(run_phase(phase, lost.robot, lost.state).status, PhaseStatus::failed);
  EXPECT_FALSE(phase.gave_way()) << "it was lost high above the table";
  Lifting two(touching_at_the_end(2));
  EXPECT_EQ(two.lift().status, PhaseStatus::ok);
}

TEST(LiftPhase, TwoContactsOfOneFingerAreOneFinger) {
  Lifting lifting([](hand::HandReading& reading, double) {
    for (std::size_t i = 1; i < reading.contacts.size(); ++i) reading.contacts[i].clear();
    reading.contacts[0].push_back({{0, 0.005, 0.015}, {0, 0, 1}, {0, 0, -1}});
  });
  expect_failed(lifting, "contacts lost");
}

TEST(LiftPhase, TipsThatBarelyTouchAreNoHold) {
  Lifting lifting([](hand::HandReading& reading, double) {
    for (auto& tip : reading.contacts) tip[0].f *= 0.09;
  });
  expect_failed(lifting, "contacts lost");
}

/// Contacts that wander along the fingertips by a way in the time of the hold.
Lifting::Script wandering(double way) {
  return [way](hand::HandReading& reading, double since) {
    const double share = std::clamp(since / LiftOptions().hold, 0.0, 1.0);
    for (auto& tip : reading.contacts) tip[0].p.z() -= share * way;
  };
}

TEST(LiftPhase, NoticesSlipDuringTheHold) {
  Lifting slipping(wandering(0.015));
  expect_failed(slipping, "slipping");
  Lifting steady(wandering(0.010));
  EXPECT_EQ(steady.lift().status, PhaseStatus::ok);
}

TEST(LiftPhase, NoNoiseOfTheSensorsIsASlip) {
  RandomStream random(3);
  Lifting lifting([&random](hand::HandReading& reading, double) {
    for (auto& tip : reading.contacts) {
      tip[0].p += 0.001 * random.normal3();
      tip[0].f += 0.05 * random.normal3();
    }
  });
  const auto report = lifting.lift();
  EXPECT_EQ(report.status, PhaseStatus::ok) << report.outcome;
}

}  // namespace
}  // namespace palpate::skills
