// SPDX-License-Identifier: Apache-2.0
#include "skills/probe/table_touch.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "hand/fake_hand.hpp"
#include "palpate/core/assets.hpp"
#include "palpate/core/se3.hpp"
#include "palpate/simulation/hand/load_hand.hpp"
#include "skills/probe/touch_table_phase.hpp"

namespace palpate::skills {
namespace {

constexpr double kHeight = 0.2;  // m, of the box over the table

/// A box that hangs below a hand without a surface, and may be turned about the world's x axis.
struct HangingBox {
  explicit HangingBox(double sigma) : object(geometry::load_known_object("box")) {
    localization::Mode mode;
    mode.T_frame_object.translation().z() = kHeight;
    mode.weight = 1;
    mode.covariance.setIdentity();
    mode.covariance *= 1e-12;
    mode.covariance(0, 0) = sigma * sigma;
    posterior.modes.push_back(mode);
  }
  TableTouchChoice choice() {
    return TableTouchChoice(robot, object, posterior, RandomStream(1, "touch table"));
  }
  geometry::ObjectModel object;
  hand::FakeHand hand;
  Executor robot{hand, hand::shadow_hand(), hand::resting_command()};
  localization::Posterior posterior;
};

TEST(TableTouchChoice, TurnsTheBoxSoThatItsHeightMeasuresTheAngleInQuestion) {
  HangingBox box(0.05);
  const auto touch = box.choice().next();
  ASSERT_TRUE(touch);
  EXPECT_GT(touch->expected_gain.information, 0.2);
  EXPECT_GT(touch->sigma, 0.001);
  // What hangs level says little about which way it is turned, and a turn about y nothing.
  EXPECT_GT(std::abs(touch->turn.x()), std::abs(touch->turn.y()) / 2);
}

TEST(TableTouchChoice, TurnsTheBoxCloseOverTheTable) {
  const geometry::ObjectModel box(geometry::load_known_object("box"));
  const Eigen::AlignedBox3d bounds = box.bounds().cast<double>();
  const double height = HangingBox(0.002).choice().travel_height();
  EXPECT_GT(height, bounds.sizes().z() / 2 + 0.02);
  EXPECT_LT(height, bounds.diagonal().norm() / 2 + 0.025);
  EXPECT_LT(height, kHeight);
}

TEST(TableTouchChoice, ExpectsLittleOfAPoseThatIsKnown) {
  HangingBox box(0.002);
  const auto touch = box.choice().next();
  ASSERT_TRUE(touch);
  EXPECT_LT(touch->expected_gain.information, 0.02);
}

TEST(TableTouchChoice, ItsTightShareIsThatOfThePosterior) {
  HangingBox known(0.002);
  EXPECT_NEAR(known.choice().tight_share(), 1, 1e-9);
  known.posterior.modes[0].weight = 0.5;
  EXPECT_NEAR(known.choice().tight_share(), 0.5, 1e-9) << "it may be anywhere else";
  // Of a normal distribution of turns with this deviation, about one axis alone.
  EXPECT_NEAR(HangingBox(0.05).choice().tight_share(),
              std::erf(2.5 * kDegree / 0.05 / std::sqrt(2)), 0.1);
}

TEST(TableTouchChoice, ATouchAsExpectedMakesThePoseTighter) {
  HangingBox box(0.05);
  TableTouchChoice choice = box.choice();
  const double before = choice.tight_share();
  const auto touch = choice.next();
  ASSERT_TRUE(touch);
  choice.made(*touch, touch->lowest);
  EXPECT_GT(choice.tight_share(), before + 0.1);
}

/// What a second touch of as long a lever measures where a first one measured that: of two normal
/// distributions, r the ratio of their deviations, the bound is ln(1 + r^2 / 2) / 2, and the touch
/// leaves r^2 / (1 + r^2) of r^2.
double left_after(double information) {
  const double r2 = 2 * std::expm1(2 * information);
  return std::log1p(r2 / (1 + r2) / 2) / 2;
}

TEST(TableTouchChoice, ATouchShowsWhichPosesAreLeft) {
  HangingBox box(0.05);
  TableTouchChoice choice = box.choice();
  const auto first = choice.next();
  ASSERT_TRUE(first);
  choice.made(*first, first->lowest);
  const auto second = choice.next();
  ASSERT_TRUE(second);
  EXPECT_GT((second->turn - first->turn).norm(), 0.1) << "the same turn again";
  EXPECT_NEAR(second->expected_gain.information, left_after(first->expected_gain.information),
              0.02);
}

TEST(TableTouchChoice, AMissedTableHasNoInformation) {
  HangingBox box(0.05);
  TableTouchChoice choice = box.choice();
  const auto first = choice.next();
  ASSERT_TRUE(first);
  choice.made(*first, std::nullopt);
  const auto second = choice.next();
  ASSERT_TRUE(second);
  EXPECT_GT(second->expected_gain.information, 0.5 * first->expected_gain.information);
}

TEST(TableTouchChoice, TheHandIsNotToMeetTheTableBeforeTheObject) {
  HangingBox box(0.05);
  auto model = simulation::load_shadow_hand(asset("shadow_hand/right_hand.xml"));
  model.spheres = {{.link = 0, .center = {0, 0, 0}, .radius = 0.3}};  // round the box
  Executor robot(box.hand, model, hand::resting_command());
  const TableTouchChoice choice(robot, box.object, box.posterior, RandomStream(1, "touch table"));
  EXPECT_FALSE(choice.next());
}

TEST(TableTouchChoice, TurnsTheHandAboutTheObject) {
  HangingBox box(0.05);
  const TableTouchChoice choice = box.choice();
  TableTouch touch;
  touch.turn = {0.3, 0, 0};
  const Eigen::Isometry3d T = choice.turned_mount(touch);
  const Eigen::Vector3d centroid =
      box.posterior.modes[0].T_frame_object * box.object.object().mass_properties.centroid;
  EXPECT_NEAR((T * centroid - centroid).norm(), 0, 1e-9);  // the mount stood at the origin
  EXPECT_NEAR(rotation_distance(T.linear(), Eigen::Matrix3d::Identity()), 0.3, 1e-9);
  EXPECT_NEAR(choice.height(), centroid.z(), 1e-12);
}

/// A hand from which a box hangs whose lowest point is this far below the mount, at any attitude,
/// over a table that bears whatever comes lower.
hand::FakeHand::Script box_over_table(double below) {
  return [below](hand::HandReading& reading) {
    const double sunk = std::max(0.0, below - reading.mount.xyz.z());
    reading.mount_force = {0, 0, 2 - 2000 * sunk};
  };
}

/// Such a hand, 0.35 m over the table, and the choice of its touches.
struct Lowering {
  explicit Lowering(double below) : hand(box_over_table(below)) { robot.wait(0.05); }
  static hand::HandCommand start() {
    hand::HandCommand command = hand::resting_command();
    command.mount.xyz.z() = 0.35;
    return command;
  }
  HangingBox box{0.02};
  hand::FakeHand hand;
  Executor robot{hand, hand::shadow_hand(), start()};
  TableTouchChoice choice{robot, box.object, box.posterior, RandomStream(1, "touch table")};
};

TEST(TouchTablePhase, LeavesTheTableAloneWhereThePoseIsTight) {
  HangingBox box(0.002);
  estimation::PoseEstimator estimator(box.object, {}, 1);
  PickState state;
  state.estimate.posterior = box.posterior;
  TouchTablePhase phase(estimator, {}, 0.5);
  const double begun = box.robot.time();
  const PhaseReport report = run_phase(phase, box.robot, state);
  EXPECT_EQ(report.status, PhaseStatus::ok);
  EXPECT_EQ(report.outcome, "tight enough (1.00)");
  EXPECT_EQ(box.robot.time(), begun);
}

TEST(TouchTablePhase, ATightShareOf1IsNeverEnough) {
  HangingBox box(0.002);
  estimation::PoseEstimator estimator(box.object, {}, 1);
  PickState state;
  state.estimate.posterior = box.posterior;
  PalpationOptions options;
  options.tight = 1;
  TouchTablePhase phase(estimator, options, 0.5);
  EXPECT_EQ(run_phase(phase, box.robot, state).outcome, "would add no information");
}

TEST(TouchTable, GoesDownUntilTheTableBearsAndUpAgain) {
  constexpr double kBelow = 0.26;
  Lowering hand(kBelow);
  TableTouch touch;
  touch.turn = {0.3, 0, 0};
  const double stands = hand.choice.turned_mount(touch).translation().z();
  touch.lowest = stands - kBelow - hand.choice.height() + 0.003;  // 3 mm off
  touch.sigma = 0.002;
  const auto lowest = touch_table(hand.robot, hand.choice, touch, 1);
  ASSERT_TRUE(lowest);
  EXPECT_NEAR(*lowest, stands - kBelow - hand.choice.height(), 0.0005);
  EXPECT_EQ(hand.robot.log().all(estimation::TouchEvent::table_touched).size(), 1u);
  const double turns = hand.choice.height() - hand.choice.travel_height();
  EXPECT_GT(turns, 0.05) << "lower than where it was held";
  EXPECT_NEAR(hand.robot.reading().mount.xyz.z(), stands - turns, 0.002) << "did not go up again";
}

/// As what has slipped in the hand does.
TEST(TouchTable, WhatMeetsTheTableMuchTooEarlyIsNotPressedHard) {
  TableTouch touch;
  touch.turn = {0.3, 0, 0};
  touch.sigma = 0.001;
  const Lowering free(0.2);
  const TableTouchChoice& choice = free.choice;
  const double stands = choice.turned_mount(touch).translation().z();
  const double turned = stands - choice.height() + choice.travel_height();
  Lowering hand(turned - 0.025);
  touch.lowest = 0.05 - choice.travel_height();  // 25 mm lower than there
  touch_table(hand.robot, hand.choice, touch, 1);
  double most = 0;  // N
  for (const auto& reading : hand.robot.log().readings) {
    most = std::max(most, 2 - reading.mount_force.z());
  }
  EXPECT_GT(most, 1.5) << "it has met the table";
  EXPECT_LT(most, 15);
}

TEST(TouchTable, GivesUpWhereNoTableIs) {
  Lowering hand(-1);
  TableTouch touch;
  touch.lowest = -0.05;
  touch.sigma = 0.002;
  EXPECT_FALSE(touch_table(hand.robot, hand.choice, touch, 1));
  EXPECT_TRUE(hand.robot.log().all(estimation::TouchEvent::table_touched).empty());
}

/// What has fallen cannot touch the table.
TEST(TouchTable, LetsNothingDownWhereNothingHangs) {
  Lowering hand(0.26);
  TableTouch touch;
  touch.lowest = -0.05;
  touch.sigma = 0.002;
  EXPECT_FALSE(touch_table(hand.robot, hand.choice, touch, 3));  // 2 N hang
  EXPECT_GT(hand.robot.reading().mount.xyz.z(), 0.26);
  EXPECT_TRUE(hand.robot.log().all(estimation::TouchEvent::table_touched).empty());
}

}  // namespace
}  // namespace palpate::skills
