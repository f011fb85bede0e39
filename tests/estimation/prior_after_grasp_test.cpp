// SPDX-License-Identifier: Apache-2.0
#include "estimation/prior_after_grasp.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "hand/descriptions.hpp"
#include "palpate/core/assets.hpp"
#include "palpate/simulation/hand/load_hand.hpp"

namespace palpate::estimation {
namespace {

localization::PosePrior prior_at(double x, double weight, double floor) {
  localization::PosePrior prior;
  prior.components.push_back({Eigen::Isometry3d::Identity(), weight, Matrix6d::Identity()});
  prior.components[0].T_frame_object.translation().x() = x;
  prior.floor = floor;
  return prior;
}

TEST(EitherOf, HalvesTheWeightsOfBothAndPutsTheHeaviestFirst) {
  const auto prior = either_of(prior_at(0.1, 0.4, 1e-3), prior_at(0.2, 0.8, 1e-5));
  ASSERT_EQ(prior.components.size(), 2u);
  EXPECT_DOUBLE_EQ(prior.components[0].weight, 0.4);
  EXPECT_DOUBLE_EQ(prior.components[0].T_frame_object.translation().x(), 0.2);
  EXPECT_DOUBLE_EQ(prior.components[1].weight, 0.2);
  EXPECT_DOUBLE_EQ(prior.floor, 1e-3);
}

/// After a grasp of an object that rested, exactly known, at a rotation of the world.
localization::PosePrior after_grasp(const geometry::KnownObject& object,
                                    const Eigen::Matrix3d& R_world_object) {
  const geometry::ObjectModel model(object);
  EventLog log;
  log.readings.assign(20, hand::resting_reading());
  log.moments = {{TouchEvent::closed, 19}};
  localization::Posterior resting;
  resting.modes.push_back({Eigen::Isometry3d(R_world_object), 1, Matrix6d::Zero(), {}});
  const EstimationOptions options;
  return prior_after_grasp({model, hand::shadow_hand(), log, 19, 19, options, 1}, resting);
}

/// Spread of the narrowest component after a grasp of a box of some mass, about and along the
/// vertical.
struct Spread {
  double turn, tilt, across, up;
};

Spread spread_after_grasp(double mass) {
  geometry::KnownObject box = geometry::load_known_object("box");
  box.mass = mass;
  const auto prior = after_grasp(box, Eigen::Matrix3d::Identity());
  const Matrix6d& covariance = prior.components.front().covariance;
  return {covariance(2, 2), covariance(0, 0), covariance(3, 3), covariance(5, 5)};
}

TEST(PriorAfterGrasp, ALightObjectMayHaveBeenPushedOverTheTable) {
  const Spread light = spread_after_grasp(0.05), heavy = spread_after_grasp(0.4);
  EXPECT_GT(light.turn, 3 * heavy.turn);
  EXPECT_GT(light.across, 2 * heavy.across);
  EXPECT_DOUBLE_EQ(light.up, heavy.up);
  EXPECT_DOUBLE_EQ(spread_after_grasp(0.01).turn, spread_after_grasp(0.001).turn);
}

TEST(PriorAfterGrasp, WhatRocksMayHaveRockedSeveralTimesAsFar) {
  const auto bottle = geometry::load_known_object("bottle");
  const Eigen::Matrix3d lying =
      Eigen::AngleAxisd(std::numbers::pi / 2, Eigen::Vector3d::UnitY()).toRotationMatrix();
  const auto prior = after_grasp(bottle, lying);
  ASSERT_EQ(prior.components.size(), 3u);
  const auto roll = [&](std::size_t i) {
    const Eigen::Matrix3d turn = prior.components[i].covariance.topLeftCorner<3, 3>();
    return std::sqrt(turn.selfadjointView<Eigen::Lower>().eigenvalues().maxCoeff());
  };
  EXPECT_GT(roll(0), 0.015);
  EXPECT_GT(roll(1), 2.5 * roll(0));
  EXPECT_LT(roll(2), 5 * roll(0)) << "the hand stops it";
}

/// Variance of the turn about x in the narrowest component, at reading 19 of a hand that closed at
/// reading 5, with another moment.
double turn_after(TouchEvent event, std::size_t reading) {
  const geometry::ObjectModel model(geometry::load_known_object("box"));
  static const auto hand = simulation::load_shadow_hand(asset("shadow_hand/right_hand.xml"));
  EventLog log;
  log.readings.assign(20, hand::resting_reading(hand));
  log.moments = {{TouchEvent::closed, 5}, {event, reading}};
  localization::Posterior before;
  before.modes.push_back({Eigen::Isometry3d::Identity(), 1, Matrix6d::Zero(), {}});
  const EstimationOptions options;
  const auto prior = prior_after_lift({model, hand, log, 5, 17, options, 1}, before);
  return prior.components.front().covariance(0, 0);
}

TEST(PriorAfterLift, WhatTouchedTheTableMayHaveTurnedInTheHand) {
  const double still = turn_after(TouchEvent::probed, 10);
  const double moved = still + 8 * std::pow(EstimationOptions().motion_angle_sigma, 2);  // 3^2 - 1
  EXPECT_NEAR(turn_after(TouchEvent::table_touched, 10), moved, 1e-9);
  EXPECT_NEAR(turn_after(TouchEvent::table_touched, 18), still, 1e-9) << "after the instant";
}

}  // namespace
}  // namespace palpate::estimation
