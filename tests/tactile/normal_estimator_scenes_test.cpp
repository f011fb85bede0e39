// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <numbers>

#include "palpate/core/se3.hpp"
#include "palpate/core/statistics.hpp"
#include "tactile/sliding_score.hpp"

/// Scenes beyond one long slide at 100 Hz: lifts, presses, other rates and speeds.
namespace palpate::tactile {
namespace {

constexpr std::uint64_t kSceneSeeds = 3;

struct Scene {
  SlidingPath path;
  std::vector<FingerSample> samples;
};

/// Straight strokes on one face, in a new direction after each `turn_every` seconds.
Scene strokes(const SlidingOptions& options, double turn_every, std::uint64_t seed) {
  RandomStream random(seed);
  const auto count = static_cast<std::size_t>(std::lround(options.seconds / options.period));
  const auto ticks = static_cast<std::size_t>(std::lround(turn_every / options.period));
  Scene scene;
  Eigen::Vector3d p = Eigen::Vector3d::Zero(), u = p;
  for (std::size_t i = 0; i < count; ++i) {
    if (i % ticks == 0) {
      const double heading = random.uniform(0, 2 * std::numbers::pi);
      u = {std::cos(heading), std::sin(heading), 0};
    }
    p += options.speed * options.period * u;
    scene.path.p.push_back(p);
    scene.path.n.push_back(Eigen::Vector3d::UnitZ());
    FingerSample sample;
    sample.time = options.period * static_cast<double>(i);
    sample.f = options.normal_force * (options.friction * u - Eigen::Vector3d::UnitZ()) +
               options.force_noise * random.normal3();
    sample.p = p + options.point_noise * random.normal3();
    scene.samples.push_back(sample);
  }
  return scene;
}

SlidingScore score_of_strokes(const std::string& name, const SlidingOptions& options,
                              double turn_every = 1) {
  SlidingScore score;
  for (std::uint64_t seed = 40; seed < 40 + kSceneSeeds; ++seed) {
    const Scene scene = strokes(options, turn_every, seed);
    add_score(*make_normal_estimator(name), scene.samples, scene.path, options.period, score);
  }
  return score;
}

/// Touches of 0.7 s on two faces in turn, with `lift` seconds between them.
SlidingScore score_of_touches(const std::string& name, double angle, double lift,
                              std::uint64_t seed) {
  SlidingOptions options;
  options.seconds = 0.7;
  const auto estimator = make_normal_estimator(name);
  SlidingScore score;
  for (int touch = 0; touch < 20; ++touch) {
    Scene scene = strokes(options, 1, seed + static_cast<std::uint64_t>(touch));
    const Eigen::Matrix3d R =
        Eigen::AngleAxisd(touch % 2 * angle, Eigen::Vector3d::UnitX()).toRotationMatrix();
    const double start = touch * (options.seconds + lift);
    for (FingerSample& sample : scene.samples) {
      sample.time += start;
      sample.p = R * sample.p + Eigen::Vector3d(0, 0, touch % 2 * 0.02);
      sample.f = R * sample.f;
      const auto estimate = estimator->update(sample);
      if (estimate.status != NormalStatus::tracked) continue;
      const Eigen::Vector3d truth = R.col(2);
      score.error_deg.push_back(angle_between_deg(estimate.n, truth));
      if (!estimate.covariance) continue;
      score.nees.push_back(normalised_error_squared(estimate.n, truth, *estimate.covariance));
    }
  }
  return score;
}

TEST(NormalScenes, AfterALiftTheNormalStartsAnew) {
  for (const double angle : {0.0, 0.7}) {
    for (const double lift : {0.1, 0.3, 0.45}) {
      const auto score = score_of_touches("s2", angle, lift, 50);
      EXPECT_LT(median(score.error_deg), 3) << angle << ' ' << lift;
      EXPECT_LT(mean(score.nees), 2.4) << angle << ' ' << lift;
    }
    EXPECT_LT(median(score_of_touches("eigen", angle, 0.3, 50).error_deg), 3) << angle;
    EXPECT_LT(median(score_of_touches("rls", angle, 0.3, 50).error_deg), 6) << angle;
  }
}

TEST(NormalScenes, AFingerThatPressesWithoutSlidingStaysUncertain) {
  for (const double point_noise : {0.0, 1e-4, 5e-4}) {
    for (const double period : {0.01, 0.1}) {
      SlidingOptions still;
      still.seconds = 30;
      still.period = period;
      still.speed = 0;
      still.friction = 0.4;
      still.point_noise = point_noise;
      EXPECT_LT(mean(score_of_strokes("s2", still, still.seconds).nees), 2.4)
          << point_noise << ' ' << period;
    }
  }
}

TEST(NormalScenes, SharpTurnsAreNoEdgesAtAnySpeed) {
  for (const double speed : {0.01, 0.02, 0.05, 0.1}) {
    SlidingOptions options;
    options.speed = speed;
    const auto score = score_of_strokes("s2", options);
    EXPECT_LT(median(score.error_deg), 3) << speed;
    EXPECT_LT(mean(score.nees), 2.4) << speed;
  }
}

TEST(NormalScenes, RecursiveLeastSquaresConvergesAtAnyRateAndSpeed) {
  for (const double period : {0.003, 0.01, 0.03}) {
    for (const double speed : {0.02, 0.1, 0.2}) {
      SlidingOptions options;
      options.period = period;
      options.speed = speed;
      SlidingScore score;
      for (std::uint64_t seed = 60; seed < 60 + kSceneSeeds; ++seed) {
        const RandomStream random(seed);
        const auto path = sliding_path(Surface::flat, options, random);
        add_score(*make_normal_estimator("rls"), samples_along(path, options, random), path, period,
                  score);
      }
      EXPECT_LT(median(score.error_deg), 5) << period << ' ' << speed;
    }
  }
}

TEST(NormalScenes, SmoothedEstimatesOfTheEndOfAContactAreNotLost) {
  SlidingOptions options;
  options.seconds = 0.18;
  const auto estimator = make_normal_estimator("s2-lag");
  std::size_t given = 0, taken = 0;
  double last = -1;
  const auto take = [&](const NormalEstimate& estimate) {
    if (estimate.status != NormalStatus::tracked) return;
    EXPECT_GT(estimate.time, last);
    last = estimate.time;
    ++taken;
  };
  for (int touch = 0; touch < 5; ++touch) {
    for (FingerSample sample : strokes(options, 1, 70).samples) {
      sample.time += touch;
      take(estimator->update(sample));
      for (const auto& late : estimator->take_late()) take(late);
      ++given;
    }
  }
  for (const auto& late : estimator->take_late(true)) take(late);
  EXPECT_EQ(taken, given);
}

}  // namespace
}  // namespace palpate::tactile
