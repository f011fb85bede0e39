// SPDX-License-Identifier: Apache-2.0
#include "palpate/skills/probe/palpation_phase.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "hand/fake_hand.hpp"
#include "palpate/core/assets.hpp"
#include "palpate/hand/shadow.hpp"
#include "palpate/hand/tip_forces.hpp"
#include "palpate/simulation/hand/load_hand.hpp"
#include "palpate/simulation/world/world.hpp"

namespace palpate::skills {
namespace {

constexpr double kTotal = 50;    // N of all fingertips, against which the weight is little
constexpr double kHold = 0.6;    // rad of the knuckles of fingers that hold
constexpr double kTouch = 0.35;  // rad of a knuckle at which a moved finger touches
constexpr double kAway = 0.02;   // rad of J4 or J0 from the hold that counts as moved
constexpr double kPress = 1.0;   // N of a fingertip

std::string finger_name(int finger) {
  return std::string(hand::kShadowFingerNames[static_cast<std::size_t>(finger)]);
}

double commanded(const hand::HandReading& reading, int finger, const char* joint) {
  return reading.joints[hand::shadow_hand().joint(finger_name(finger) + joint)];
}

/// A finger that holds, or has been moved aside and closed on another spot.
bool touches(const hand::HandReading& reading, int finger) {
  const bool moved = std::abs(commanded(reading, finger, "J4")) > kAway;
  return commanded(reading, finger, "J3") > (moved ? kTouch : kHold) - 1e-9;
}

/// A contact with the top of a box that lies on the table.
void press(const hand::Description& model, int finger, hand::HandReading& reading) {
  const auto index = static_cast<std::size_t>(finger);
  const auto link = static_cast<std::size_t>(model.fingers[index].link);
  const Eigen::Isometry3d T_link_mount =
      hand::forward_kinematics(model, reading.joints)[link].inverse();
  const Eigen::Vector3d p(0.02 * (finger - 2), 0.01 * (finger % 2), 0.05);
  const Eigen::Vector3d n = T_link_mount.linear() * Eigen::Vector3d::UnitZ();
  reading.contacts[index] = {{T_link_mount * p, n, -kPress * n}};
}

/// A hand that holds a box with the thumb and four fingers, and a pose of the box that is in doubt.
struct Hold {
  using Rule = std::function<bool(const hand::HandReading&, int finger)>;

  explicit Hold(Rule rule = touches)
      : hand([this, rule = std::move(rule)](hand::HandReading& reading) {
          for (int finger = 0; finger < hand::kShadowFingers; ++finger) {
            if (finger == 0 ? thumb_touches : rule(reading, finger)) press(model, finger, reading);
          }
        }),
        robot(hand, model, holding(), {}, nullptr, {{.tip_reach = 1}, {}, {}}) {
    grasp.min_press = kTotal;
    options.certain = 1;
    options.regrasps = 0;
    options.min_gain_rate = 0;
    options.balance = 2;  // all contacts are on top
    options.spread = 0.3;
    options.bend = 0;    // J4 alone determines where a finger is
    options.likely = 0;  // the poses in doubt have nothing to do with what the hand senses
    locate.search.proposals = 10000;
    locate.search.particles = 200;
    locate.free_space = false;
    for (const double turn : {0.0, 1.0}) {
      localization::Mode mode;
      mode.T_frame_object.translate(Eigen::Vector3d(0.1, 0, 0));
      mode.T_frame_object.rotate(Eigen::AngleAxisd(turn, Eigen::Vector3d::UnitZ()));
      mode.weight = 0.5;
      state.estimate.posterior.modes.push_back(mode);
    }
    robot.wait(0.2);
    robot.add_event(estimation::TouchEvent::closed);
  }

  static hand::HandCommand holding() {
    hand::HandCommand command = hand::resting_command();
    for (int finger = 1; finger < hand::kShadowFingers; ++finger) {
      command.positions[hand::shadow_hand().actuator(finger_name(finger) + "J3")] = kHold;
    }
    return command;
  }

  PhaseReport probe(estimation::TouchEvent instant = estimation::TouchEvent::closed) {
    estimation::PoseEstimator estimator(object, locate, 1);
    PalpationPhase phase(estimator, options, grasp, instant);
    return run_phase(phase, robot, state);
  }

  std::size_t probes() const { return robot.log().all(estimation::TouchEvent::probed).size(); }

  bool thumb_touches = true;
  hand::Description model =
      hand::with_soft_actuators(simulation::load_shadow_hand(asset("shadow_hand/right_hand.xml")));
  geometry::ObjectModel object{geometry::load_known_object("box")};
  PalpationOptions options;
  GraspOptions grasp;
  estimation::EstimationOptions locate;
  PickState state;
  hand::FakeHand hand;
  Executor robot;
};

TEST(PalpationPhase, TouchesAnotherSpotAndReturns) {
  Hold hold;
  hold.options.max = 1;
  const auto before = hold.robot.command().positions;
  EXPECT_EQ(hold.probe().status, PhaseStatus::ok);
  ASSERT_EQ(hold.probes(), 1u);
  EXPECT_LT((hold.robot.command().positions - before).norm(), 1e-12);
  const auto& reading =
      hold.robot.log().readings[hold.robot.log().at(estimation::TouchEvent::probed).value()];
  int moved = 0;
  for (int finger = 1; finger < hand::kShadowFingers; ++finger) {
    if (std::abs(commanded(reading, finger, "J4")) <= kAway) continue;
    ++moved;
    EXPECT_GT(hand::tip_force(reading, finger), hold.options.touch_force);
    EXPECT_LT(commanded(reading, finger, "J3"), kHold);  // it stopped at the touch
  }
  EXPECT_EQ(moved, 1);
  EXPECT_GT(hold.robot.log().at(estimation::TouchEvent::closed),
            hold.robot.log().at(estimation::TouchEvent::probed));
}

TEST(PalpationPhase, NoFingerLetsGoOfWhatHangs) {
  Hold hold;
  hold.robot.add_event(estimation::TouchEvent::held);
  hold.probe(estimation::TouchEvent::held);
  EXPECT_EQ(hold.probes(), 0u);
  hold.probe();
  EXPECT_GT(hold.probes(), 0u);
}

TEST(PalpationPhase, LeavesAPoseAloneThatIsCertain) {
  Hold hold;
  hold.options.certain = 0.4;
  EXPECT_EQ(hold.probe().status, PhaseStatus::ok);
  EXPECT_EQ(hold.probes(), 0u);
}

TEST(PalpationPhase, MakesNoMoveThatShouldNotMeetTheObject) {
  Hold hold;
  hold.options.likely = 0.6;
  EXPECT_EQ(hold.probe().status, PhaseStatus::ok);
  EXPECT_EQ(hold.probes(), 0u);
}

TEST(PalpationPhase, AHandThatLacksAFingerKeepsWhatItHolds) {
  Hold hold;
  hold.options.max = 0;
  hold.options.regrasps = 2;
  hold.probe();
  EXPECT_TRUE(hold.state.next_grasp);
  hold.robot.distrust(4, "senses nothing");
  hold.probe();
  EXPECT_FALSE(hold.state.next_grasp);
}

TEST(PalpationPhase, MovesNothingWithoutAThumbThatHolds) {
  Hold hold;
  hold.thumb_touches = false;
  hold.robot.wait(0.2);
  const double before = hold.robot.time();
  EXPECT_EQ(hold.probe().status, PhaseStatus::ok);
  EXPECT_EQ(hold.probes(), 0u);
  EXPECT_EQ(hold.robot.time(), before);
}

TEST(PalpationPhase, FailsWhenTheOthersLoseTouch) {
  bool lost = false;
  Hold hold([&lost](const hand::HandReading& reading, int finger) {
    for (int other = 1; other < hand::kShadowFingers; ++other) {
      lost |= commanded(reading, other, "J3") < kHold - 0.1;  // one opens: the object falls
    }
    return !lost && touches(reading, finger);
  });
  hold.options.max = 5;
  EXPECT_EQ(hold.probe().status, PhaseStatus::failed);
  EXPECT_EQ(hold.probes(), 1u);  // and does not go on
}

TEST(PalpationPhase, AFingerThatFindsNothingReturns) {
  Hold hold([](const hand::HandReading& reading, int finger) {
    return commanded(reading, finger, "J3") > kHold - 1e-9 &&
           std::abs(commanded(reading, finger, "J4")) <= kAway;
  });
  hold.options.max = 1;
  const auto before = hold.robot.command().positions;
  EXPECT_EQ(hold.probe().status, PhaseStatus::ok);
  EXPECT_EQ(hold.probes(), 1u);
  EXPECT_LT((hold.robot.command().positions - before).norm(), 1e-12);
}

/// As in the test above, a touch in vain takes longest.
TEST(PalpationPhase, BeginsNoTouchThatItsTimeMayCutShort) {
  Hold hold([](const hand::HandReading& reading, int finger) {
    return commanded(reading, finger, "J3") > kHold - 1e-9 &&
           std::abs(commanded(reading, finger, "J4")) <= kAway;
  });
  hold.options.max = 64;
  hold.options.bend = 0.5;  // eight spots for each of four fingers
  const auto before = hold.robot.command().positions;
  const auto report = hold.probe();
  EXPECT_EQ(report.status, PhaseStatus::ok);  // not timed out
  EXPECT_GT(report.robot_seconds, 50) << report.outcome;
  EXPECT_LT(hold.probes(), 32u);
  EXPECT_LT((hold.robot.command().positions - before).norm(), 1e-12);
}

}  // namespace
}  // namespace palpate::skills
