// SPDX-License-Identifier: Apache-2.0
#include "estimation/prior_after_grasp.hpp"

#include <gtest/gtest.h>

#include "hand/descriptions.hpp"

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

/// Spread of the narrowest component after a grasp of a box of some mass, about and along the
/// vertical.
struct Spread {
  double turn, tilt, across, up;
};

Spread spread_after_grasp(double mass) {
  geometry::KnownObject box = geometry::load_known_object("box");
  box.mass = mass;
  const geometry::ObjectModel model(box);
  const hand::Description& hand = hand::shadow_hand();
  EventLog log;
  log.readings.assign(20, hand::resting_reading());
  log.moments = {{TouchEvent::closed, 19}};
  localization::Posterior resting;
  resting.modes.push_back({Eigen::Isometry3d::Identity(), 1, Matrix6d::Zero(), {}});
  const EstimationOptions options;
  const auto prior = prior_after_grasp({model, hand, log, 19, 19, options, 1}, resting);
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

}  // namespace
}  // namespace palpate::estimation
