// SPDX-License-Identifier: Apache-2.0
#include "palpate/localization/information/sweep_choice.hpp"

#include <gtest/gtest.h>

namespace palpate::localization {
namespace {

const geometry::ObjectModel& box() {
  static const geometry::ObjectModel model(geometry::load_known_object("box"));
  return model;
}

localization::Mode mode_at(const Eigen::Vector3d& place, double weight) {
  localization::Mode mode;
  mode.T_frame_object.translation() = place;
  mode.weight = weight;
  return mode;
}

const SweepingFinger kBall = {{{Eigen::Vector3d::Zero(), 0.007}}, {}};
const Sweep kAlongX = {{0.2, 0, 0}, {-0.2, 0, 0}};
const Sweep kAlongY = {{0, 0.2, 0}, {0, -0.2, 0}};

TEST(MostTellingSweep, IsAcrossTheDirectionInWhichTheModesDiffer) {
  localization::Posterior posterior;
  posterior.modes = {mode_at({0, 0, 0}, 0.5), mode_at({0.02, 0, 0}, 0.5)};
  const auto best = most_telling_sweep(box(), posterior, kBall, {kAlongY, kAlongX});
  ASSERT_TRUE(best);
  EXPECT_EQ(best->sweep.from, kAlongX.from);
  EXPECT_EQ(best->index, 1u);
  EXPECT_NEAR(best->information, 0.5, 1e-9);  // two equal modes that are surely told apart
}

TEST(MostTellingSweep, UnlikelyModesAreWorthLess) {
  localization::Posterior posterior;
  posterior.modes = {mode_at({0, 0, 0}, 0.95), mode_at({0.02, 0, 0}, 0.05)};
  const auto best = most_telling_sweep(box(), posterior, kBall, {kAlongX});
  ASSERT_TRUE(best);
  EXPECT_NEAR(best->information, 2 * 0.95 * 0.05, 1e-9);
}

TEST(MostTellingSweep, AFreeAxisLeavesSomethingToTell) {
  localization::Posterior posterior;
  posterior.modes = {mode_at({0, 0, 0}, 1)};
  posterior.modes[0].free_axis = {Eigen::Vector3d::Zero(), Eigen::Vector3d::UnitZ(), 1.5};
  EXPECT_TRUE(most_telling_sweep(box(), posterior, kBall, {kAlongX}));
}

TEST(MostTellingSweep, OneModeLeavesNothingToTell) {
  localization::Posterior posterior;
  posterior.modes = {mode_at({0, 0, 0}, 1)};
  EXPECT_FALSE(most_telling_sweep(box(), posterior, kBall, {kAlongX, kAlongY}));
  EXPECT_FALSE(most_telling_sweep(box(), posterior, kBall, {}));
}

TEST(MostTellingSweep, BlockedByAnotherPartOfTheHandTellsNothing) {
  localization::Posterior posterior;
  posterior.modes = {mode_at({0, 0, 0}, 0.5), mode_at({0.02, 0, 0}, 0.5)};
  SweepingFinger blocked = kBall;
  blocked.rest.push_back({{0, 0, 0}, 0.02});
  EXPECT_FALSE(most_telling_sweep(box(), posterior, blocked, {kAlongX}));
}

SweepingFinger turned_ball(double yaw) {
  SweepingFinger finger = kBall;
  finger.R_world_base = Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  return finger;
}

TEST(MostRefiningSweep, GoesWhereThePlaceIsNotKnown) {
  const std::vector<Sweep> sweeps = {kAlongX, kAlongY};
  const std::vector<TurnedSweep> done = {{kAlongX, 0}, {kAlongX, 0}};
  const auto best =
      most_refining_sweep(box(), Eigen::Isometry3d::Identity(), {turned_ball(0)}, sweeps, done);
  ASSERT_TRUE(best);
  EXPECT_EQ(best->sweep.sweep.from, kAlongY.from);
  EXPECT_LT(best->after, best->before);
}

TEST(MostRefiningSweep, TurnsTheHandToTellItsOffsetFromThePlace) {
  const std::vector<SweepingFinger> fingers = {turned_ball(0), turned_ball(M_PI)};
  const std::vector<TurnedSweep> done(6, {kAlongX, 0});
  const auto best =
      most_refining_sweep(box(), Eigen::Isometry3d::Identity(), fingers, {kAlongX}, done);
  ASSERT_TRUE(best);
  EXPECT_EQ(best->sweep.turn, 1U);
}

TEST(MostRefiningSweep, NeedsATouch) {
  const Sweep beside = {{0.3, 0.3, 0}, {0.2, 0.3, 0}};
  EXPECT_FALSE(
      most_refining_sweep(box(), Eigen::Isometry3d::Identity(), {turned_ball(0)}, {beside}, {}));
}

}  // namespace
}  // namespace palpate::localization
