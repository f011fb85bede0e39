// SPDX-License-Identifier: Apache-2.0
#include "palpate/skills/explore/calibrate_phase.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "hand/fake_hand.hpp"
#include "palpate/core/assets.hpp"
#include "palpate/evaluation/trial.hpp"
#include "palpate/hand/faulty_hand.hpp"
#include "palpate/hand/kinematics.hpp"
#include "palpate/hand/shadow.hpp"
#include "palpate/simulation/hand/load_hand.hpp"
#include "palpate/skills/grasp/grasp_phase.hpp"
#include "palpate/tactile/contacts/contact_window.hpp"

namespace palpate::skills {
namespace {

hand::Description drawn_hand() {
  return hand::with_soft_actuators(
      simulation::load_shadow_hand(asset("shadow_hand/right_hand.xml")));
}

/// Root mean square distance of the fingertips of an open hand from where they are, m.
double tip_error(const hand::Description& believed, const hand::Description& real) {
  const auto joints = hand::joints_in_free_flexion(real, real.postures.top.open);
  const auto there = hand::forward_kinematics(believed, joints);
  const auto here = hand::forward_kinematics(real, joints);
  double sum = 0;
  for (const auto& finger : real.fingers) {
    const auto i = static_cast<std::size_t>(finger.link);
    sum += (there[i].translation() - here[i].translation()).squaredNorm();
  }
  return std::sqrt(sum / hand::kShadowFingers);
}

struct Calibrating {
  explicit Calibrating(std::uint64_t seed, const simulation::WorldOptions& world_options = {})
      : world(object, world_options, seed),
        hand(started(world, evaluation::draw_start(object, {}, seed))),
        robot(hand, world.hand_model(), evaluation::waiting_command(world.hand_model())) {}

  /// Its clock and its mount must not jump before the robot's eyes.
  static hand::Hand& started(simulation::World& world, const simulation::Start& start) {
    world.reset(start, evaluation::waiting_command(world.hand_model()));
    return world.hand();
  }
  PhaseReport calibrate() {
    CalibratePhase phase(options);
    PickState state;
    return run_phase(phase, robot, state);
  }

  geometry::KnownObject object = geometry::load_known_object("bunny");
  simulation::World world;
  hand::Hand& hand;
  Executor robot;
  CalibrateOptions options;
};

TEST(CalibratePhase, FindsTheFingertipsWithoutTouchingTheObject) {
  Calibrating scene(3);
  const auto real = drawn_hand();
  const double before = tip_error(scene.robot.model(), real);
  scene.robot.wait(0.5);  // until the object has come to rest
  const auto T_world_object = scene.world.truth().T_world_object;
  const auto report = scene.calibrate();
  EXPECT_EQ(report.status, PhaseStatus::ok) << report.outcome;
  EXPECT_LT(tip_error(scene.robot.model(), real), before / 3);
  EXPECT_LT(
      (scene.world.truth().T_world_object.translation() - T_world_object.translation()).norm(),
      1e-4);
  EXPECT_FALSE(scene.world.diverged());
  EXPECT_GT(scene.robot.reading().mount.xyz.z(), 0.3);  // clear of all that stands about
  // Within three standard deviations of what it says of itself.
  double stated = 0;
  for (int finger = 0; finger < hand::kShadowFingers; ++finger) {
    stated += 3 * std::pow(tactile::link_offset_sigma(scene.robot.model(), finger), 2);
  }
  EXPECT_LT(tip_error(scene.robot.model(), real), 3 * std::sqrt(stated / hand::kShadowFingers));
}

/// The angle between two tables, rad.
double apart(const Eigen::Isometry3d& a, const Eigen::Isometry3d& b) {
  return Eigen::Vector3d(a.linear().col(2)).cross(Eigen::Vector3d(b.linear().col(2))).norm();
}

TEST(CalibratePhase, FindsTheTableTheMountAndTheLoadOfAnUnknownRobot) {
  Calibrating scene(6, simulation::WorldOptions::realistic());
  const auto report = scene.calibrate();
  EXPECT_EQ(report.status, PhaseStatus::ok) << report.outcome;
  EXPECT_LT(apart(scene.robot.log().T_world_table, scene.world.truth().T_world_table), 0.006)
      << "a third of the largest tilt that is drawn";
  EXPECT_LT(tip_error(scene.robot.model(), drawn_hand()), 0.0015);
  EXPECT_LT(steady_load(scene.robot).norm(), 0.3);
}

TEST(CalibratePhase, SwappedFingertipsAreFoundAndTheHandIsCalibratedAllTheSame) {
  Calibrating scene(6, simulation::WorldOptions::realistic());
  hand::FaultyHand swapped(scene.hand,
                           {.fault = hand::InjectedFault::fingers_swapped, .finger = 2});
  Executor robot(swapped, scene.robot.model(), evaluation::waiting_command(scene.robot.model()));
  CalibratePhase phase(scene.options);
  PickState state;
  const auto report = run_phase(phase, robot, state);
  EXPECT_EQ(report.status, PhaseStatus::ok) << report.outcome;
  ASSERT_EQ(robot.survived().size(), 1U);
  EXPECT_EQ(robot.survived()[0].fault, Fault::touch_swapped);
  EXPECT_TRUE(robot.trust().trusted(2) && robot.trust().trusted(3));
  EXPECT_LT(tip_error(robot.model(), drawn_hand()), 0.0015);
}

/// A hand on an arm that meets the table in some attitudes, which shows only on the way down.
struct OnAShortArm : hand::FaultyHand {
  explicit OnAShortArm(hand::Hand& hand) : FaultyHand(hand, {}) {}
  hand::PathFeasibility check_path(std::span<const hand::MountPosition> way) const override {
    hand::PathFeasibility answer;
    const bool down = way.size() > 1 && way.back().xyz.z() < way.front().xyz.z();
    const bool slow = way.size() != kAsked && way.back().ypr.z() > 0.3;
    if (down && slow) answer = {.obstacle = "the wrist would meet the table", .feasible = 1};
    return answer;
  }
  static constexpr std::size_t kAsked = 100;  // positions of a way that is not yet taken
};

TEST(CalibratePhase, LeavesOutTouchesOnWhoseWayAnArmIsObstructed) {
  Calibrating scene(6, simulation::WorldOptions::realistic());
  OnAShortArm hand(scene.hand);
  Executor robot(hand, scene.robot.model(), evaluation::waiting_command(scene.robot.model()));
  CalibratePhase phase(scene.options);
  PickState state;
  const auto report = run_phase(phase, robot, state);
  EXPECT_EQ(report.status, PhaseStatus::ok) << report.outcome;
  EXPECT_LT(tip_error(robot.model(), drawn_hand()), 0.002);
}

TEST(CalibratePhase, TheLogAloneGivesTheSameHand) {
  Calibrating scene(4);
  scene.options.touches = 6;
  const auto drawn = scene.robot.model();
  scene.calibrate();
  const auto again = calibration(drawn, scene.robot.log(), scene.options).hand;
  EXPECT_EQ(again.kinematic_error, scene.robot.model().kinematic_error);
  EXPECT_EQ(tip_error(again, scene.robot.model()), 0);
  EXPECT_LT(again.kinematic_error, drawn.kinematic_error);
}

TEST(CalibratePhase, KnowsLessFromNoisierTouches) {
  Calibrating scene(4);
  scene.options.touches = 6;
  const auto drawn = scene.robot.model();
  scene.calibrate();
  estimation::EventLog noisy = scene.robot.log();
  RandomStream random(1);
  for (auto& reading : noisy.readings) {
    for (auto& contacts : reading.contacts) {
      for (auto& contact : contacts) contact.p += 0.01 * random.normal3();
    }
  }
  const auto calibrated = calibration(drawn, noisy, scene.options).hand;
  EXPECT_GT(calibrated.kinematic_error, scene.robot.model().kinematic_error);
  EXPECT_LT(calibrated.kinematic_error, drawn.kinematic_error);
}

TEST(CalibratePhase, LeavesTheHandThatSensesNothing) {
  hand::FakeHand hand;
  hand::Description model = drawn_hand();
  model.kinematic_error = 0.002;
  Executor robot(hand, model, evaluation::waiting_command(model));
  CalibrateOptions options;
  options.touches = 3;
  CalibratePhase phase(options);
  PickState state;
  const auto report = run_phase(phase, robot, state);
  EXPECT_EQ(report.status, PhaseStatus::failed);
  EXPECT_EQ(robot.model().kinematic_error, 0.002);
  EXPECT_EQ(tip_error(robot.model(), model), 0);
}

TEST(CalibratePhase, LeavesTheHandWhoseTouchesContradictOneAnother) {
  hand::Description model = drawn_hand();
  model.kinematic_error = 0.002;
  int ticks = 0;
  hand::FakeHand hand([&](hand::HandReading& reading) {  // senses things in the air, ever higher
    if (reading.mount.xyz.z() > 0.2) return;
    for (auto& contacts : reading.contacts) {
      contacts = {{{0, 0.03 * std::sin(0.01 * ++ticks), 0.02}, {0, 1, 0}, {0, -1, 0}}};
    }
  });
  Executor robot(hand, model, evaluation::waiting_command(model));
  CalibrateOptions options;
  options.touches = 30;
  CalibratePhase phase(options);
  PickState state;
  const auto report = run_phase(phase, robot, state);
  EXPECT_EQ(report.status, PhaseStatus::failed) << report.outcome;
  EXPECT_EQ(tip_error(robot.model(), model), 0);
}

/// A hand whose driver gives the force of the hand on the arm.
struct ReversedLoad : hand::Hand {
  explicit ReversedLoad(hand::Hand& it) : inner(it) {}
  hand::HandReading step(const hand::HandCommand& command) override {
    hand::HandReading reading = inner.step(command);
    reading.mount_force = -reading.mount_force;
    return reading;
  }
  hand::Hand& inner;
};

TEST(CalibratePhase, ALoadOfTheWrongSignIsAFault) {
  Calibrating scene(3);
  ReversedLoad reversed(scene.world.hand());
  scene.world.reset(evaluation::draw_start(scene.object, {}, 3),
                    evaluation::waiting_command(scene.world.hand_model()));
  Executor robot(reversed, scene.world.hand_model(),
                 evaluation::waiting_command(scene.world.hand_model()));
  CalibrateOptions options;
  options.touches = 5;  // the load is read before each
  CalibratePhase phase(options);
  PickState state;
  EXPECT_EQ(run_phase(phase, robot, state).status, PhaseStatus::fault);
  EXPECT_EQ(robot.fault().fault, Fault::out_of_range);
  EXPECT_NE(robot.fault().detail.find("mount_force has the wrong sign"), std::string::npos);
}

TEST(CalibratePhase, AForceOfTheWrongSignIsNamed) {
  hand::Description model = drawn_hand();
  hand::FakeHand fake(
      [&](hand::HandReading& reading) {  // a table at a height of 0
        const auto links = hand::forward_kinematics(model, reading.joints);
        double depth = 0;
        for (std::size_t i = 0; i < model.fingers.size(); ++i) {
          const hand::Finger& finger = model.fingers[i];
          const Eigen::Isometry3d T =
              reading.mount.pose() * links[static_cast<std::size_t>(finger.link)];
          const double below = finger.tip.radius - (T * finger.tip.b).z();
          if (below <= 0) continue;
          depth = std::max(depth, below);
          const Eigen::Vector3d up = T.linear().transpose() * Eigen::Vector3d::UnitZ();
          reading.contacts[i] = {{finger.tip.b - finger.tip.radius * up, up, 2 * up}};
        }
        reading.mount_force.z() = -2000 * depth;
      },
      model);
  Executor robot(fake, model, evaluation::waiting_command(model));
  CalibrateOptions options;
  options.touches = 40;
  CalibratePhase phase(options);
  PickState state;
  run_phase(phase, robot, state);
  ASSERT_FALSE(robot.survived().empty());
  EXPECT_NE(robot.survived()[0].detail.find("f.n > 0"), std::string::npos);
}

}  // namespace
}  // namespace palpate::skills
