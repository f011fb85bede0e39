// SPDX-License-Identifier: Apache-2.0
#include "palpate/localization/information/next_touch.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "localization/scenes.hpp"
#include "palpate/core/error.hpp"

namespace palpate::localization {
namespace {

TouchAction along_x(double y, double z) { return {{-0.2, y, z}, {1, 0, 0}, 0.4, 1}; }

PredictedTouch hit_at(double distance, const Eigen::Vector3d& normal = {-1, 0, 0}) {
  return {true, distance, normal};
}

TEST(PredictTouch, MeetsABoxsFace) {
  const auto touch =
      predict_touch(model_of("box"), Eigen::Isometry3d::Identity(), along_x(0, 0.01), 0.0075);
  ASSERT_TRUE(touch.hit);
  EXPECT_NEAR(touch.distance, 0.2 - 0.025 - 0.0075, 5e-4);
  EXPECT_GT(touch.normal.dot(Eigen::Vector3d(-1, 0, 0)), 0.999);
}

TEST(PredictTouch, AgreesWithTheMeshFromAnySide) {
  const geometry::ObjectModel& model = model_of("bunny");
  RandomStream random(4);
  int hits = 0;
  for (int i = 0; i < 50; ++i) {
    const Eigen::Isometry3d T = random_pose(random);
    const Eigen::Vector3d direction = random.unit_vector();
    const Eigen::Vector3d aim = T.translation() + 0.02 * random.normal3();
    const TouchAction probe{aim - 0.2 * direction, direction, 0.4, 1};
    const auto touch = predict_touch(model, T, probe, 0.0075);
    if (!touch.hit) continue;
    ++hits;
    const Eigen::Vector3d end = probe.start + touch.distance * direction;
    EXPECT_NEAR(mesh_of(model).signed_distance(T.inverse() * end), 0.0075, 1e-3);
  }
  EXPECT_GT(hits, 20);
}

TEST(PredictTouch, MissesWhatIsBesideOrBeyondReach) {
  const Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  EXPECT_FALSE(predict_touch(model_of("box"), T, along_x(0.1, 0), 0.0075).hit);
  TouchAction shorter = along_x(0, 0);
  shorter.reach = 0.1;
  EXPECT_FALSE(predict_touch(model_of("box"), T, shorter, 0.0075).hit);
}

TEST(InformationBound, IsNoneForEqualOutcomesAndLnCountForDistinctOnes) {
  EXPECT_NEAR(information_bound({hit_at(0.1), hit_at(0.1), hit_at(0.1)}), 0, 1e-12);
  EXPECT_NEAR(information_bound({hit_at(0.1), hit_at(0.2), hit_at(0.3)}), std::log(3.0), 1e-9);
  EXPECT_NEAR(information_bound({hit_at(0.1), {}, hit_at(0.1), {}}), std::log(2.0), 1e-12);
}

TEST(InformationBound, CountsNormals) {
  EXPECT_GT(information_bound({hit_at(0.1), hit_at(0.1, {0, 0, 1})}), 0.6);
}

TEST(InformationBound, OfWeightedPosesIsAtMostTheirEntropy) {
  const std::vector<PredictedTouches> apart{{hit_at(0.1)}, {hit_at(0.2)}, {PredictedTouch{}}};
  const double entropy = -(0.7 * std::log(0.7) + 0.2 * std::log(0.2) + 0.1 * std::log(0.1));
  EXPECT_NEAR(information_bound(apart, {0.7, 0.2, 0.1}), entropy, 1e-9);
  EXPECT_NEAR(information_bound(apart, {7, 2, 1}), entropy, 1e-9);
  EXPECT_NEAR(information_bound(apart, {1, 0, 0}), 0, 1e-12);
}

TEST(InformationBound, AddsUpWhatSeveralFingersSense) {
  const double step = 0.004;  // twice the error of a touch: not distinguished for sure
  const std::vector<PredictedTouches> one{{hit_at(0)}, {hit_at(step)}};
  const std::vector<PredictedTouches> two{{hit_at(0), hit_at(0)}, {hit_at(step), hit_at(step)}};
  const std::vector<PredictedTouches> alike{{hit_at(0), hit_at(0)}, {hit_at(0), hit_at(step)}};
  const std::vector<double> even{1, 1};
  EXPECT_GT(information_bound(two, even), 1.2 * information_bound(one, even));
  EXPECT_NEAR(information_bound(alike, even), information_bound(one, even), 1e-12);
}

TEST(InformationBound, RefusesOutcomesThatDoNotMatch) {
  const auto bound = [](const std::vector<PredictedTouches>& outcomes,
                        const std::vector<double>& weights) {
    return information_bound(outcomes, weights);
  };
  EXPECT_THROW(bound({{hit_at(0)}, {hit_at(1)}}, {1}), BadInput);
  EXPECT_THROW(bound({{hit_at(0)}, {hit_at(1), hit_at(1)}}, {1, 1}), BadInput);
  EXPECT_THROW(bound({{hit_at(0)}, {hit_at(1)}}, {0, 0}), BadInput);
  EXPECT_THROW(bound({{hit_at(0)}, {hit_at(1)}}, {1, -1}), BadInput);
  EXPECT_EQ(information_bound(std::vector<PredictedTouches>{}, std::vector<double>{}), 0);
}

Posterior two_boxes() {
  Posterior posterior;
  posterior.status = PoseStatus::ambiguous;
  for (const double y : {0.0, 0.03}) {
    Mode mode;
    mode.T_frame_object.translation().y() = y;
    mode.weight = 0.5;
    mode.covariance = Matrix6d::Identity() * 1e-8;
    posterior.modes.push_back(mode);
  }
  return posterior;
}

TEST(ChooseProbe, TakesTheOneThatDistinguishesTheModes) {
  // Along x both boxes are alike in the middle; 6 cm to the side only one is hit.
  const std::vector<TouchAction> probes{along_x(0.0, 0), along_x(0.015, 0.02), along_x(0.06, 0)};
  const auto choice = choose_touch(model_of("box"), two_boxes(), probes, RandomStream(1));
  EXPECT_EQ(choice.index, 2U);
  EXPECT_NEAR(choice.information, std::log(2.0), 0.05);
}

TEST(ChooseProbe, PrefersTheCheaperOfTwoEqualOnes) {
  std::vector<TouchAction> probes{along_x(0.06, 0), along_x(0.06, 0)};
  probes[0].seconds = 3;
  EXPECT_EQ(choose_touch(model_of("box"), two_boxes(), probes, RandomStream(1)).index, 1U);
}

TEST(ChooseProbe, RefusesBadInput) {
  const auto choose = [](const Posterior& posterior, const std::vector<TouchAction>& probes) {
    return choose_touch(model_of("box"), posterior, probes, RandomStream(1));
  };
  EXPECT_THROW(choose(two_boxes(), {}), BadInput);
  EXPECT_THROW(choose({}, {along_x(0, 0)}), BadInput);
  TouchAction bad = along_x(0, 0);
  bad.start.x() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(choose(two_boxes(), {bad}), BadInput);
  bad = along_x(0, 0);
  bad.direction *= 2;
  EXPECT_THROW(choose(two_boxes(), {bad}), BadInput);
}

TEST(DrawPoses, FollowsWeightsAndFreeAxes) {
  Posterior posterior = two_boxes();
  posterior.modes[0].weight = 0.75;
  posterior.modes[1].weight = 0.25;
  posterior.modes[1].free_axis = FreeAxis{{0, 0.03, 0}, {0, 0, 1}, M_PI};
  RandomStream random(1);
  int first = 0;
  double widest = 0;
  for (const auto& T : draw_poses(posterior, 400, random)) {
    first += T.translation().y() < 0.015;
    widest = std::max(widest, rotation_distance(T.linear(), Eigen::Matrix3d::Identity()));
  }
  EXPECT_NEAR(first, 300, 1);
  EXPECT_GT(widest, 2.5);
}

}  // namespace
}  // namespace palpate::localization
