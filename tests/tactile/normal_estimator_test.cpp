// SPDX-License-Identifier: Apache-2.0
#include "palpate/tactile/normals/normal_estimator.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "normal_clusters.hpp"
#include "palpate/core/error.hpp"
#include "palpate/core/statistics.hpp"
#include "tactile/normals/plane_fit.hpp"
#include "tactile/normals/rls.hpp"
#include "tactile/normals/s2_filter.hpp"
#include "tactile/normals/s2_smoother.hpp"
#include "tactile/sliding_score.hpp"

namespace palpate::tactile {
namespace {

constexpr std::uint64_t kSeeds = 6;

SlidingScore score_of(const std::string& name, Surface surface, const SlidingOptions& options,
                      std::uint64_t seeds = kSeeds) {
  SlidingScore score;
  for (std::uint64_t seed = 0; seed < seeds; ++seed) {
    const RandomStream random(seed);
    const auto path = sliding_path(surface, options, random);
    add_score(*make_normal_estimator(name), samples_along(path, options, random), path,
              options.period, score);
  }
  return score;
}

std::string estimator_name(const testing::TestParamInfo<std::string>& estimator) {
  std::string name = estimator.param;
  std::erase(name, '-');
  return name;
}

class AnyEstimator : public testing::TestWithParam<std::string> {};
INSTANTIATE_TEST_SUITE_P(All, AnyEstimator, testing::ValuesIn(normal_estimators()), estimator_name);

TEST_P(AnyEstimator, TurnsWithItsInput) {
  SlidingOptions options;
  options.seconds = 3;
  RandomStream random(11);
  const auto path = sliding_path(Surface::edge, options, random);
  auto samples = samples_along(path, options, random);
  const Eigen::Matrix3d R = random.rotation();
  const Eigen::Vector3d t = random.normal3();
  const auto still = make_normal_estimator(GetParam()), turned = make_normal_estimator(GetParam());
  for (FingerSample sample : samples) {
    const auto a = still->update(sample);
    sample.p = R * sample.p + t;
    sample.f = R * sample.f;
    sample.tip_normal = R * sample.tip_normal.value();
    const auto b = turned->update(sample);
    ASSERT_EQ(a.status, b.status);
    if (a.status == NormalStatus::none) continue;
    ASSERT_LT(angle_between_deg(R * a.n, b.n), 2) << a.time;  // tangents decide what is an outlier
  }
}

TEST_P(AnyEstimator, SamplesOfNoUseGiveNoNewNormal) {
  SlidingOptions options;
  options.seconds = 2;
  const RandomStream random(12);
  const auto samples = samples_along(sliding_path(Surface::flat, options, random), options, random);
  const auto estimator = make_normal_estimator(GetParam());
  FingerSample bad = samples[0];
  bad.p.setConstant(std::numeric_limits<double>::quiet_NaN());
  bad.flags.set(SampleFlag::not_finite);
  const auto before = estimator->update(bad);
  EXPECT_EQ(before.status, NormalStatus::none);
  EXPECT_TRUE(std::isnan(before.n.x()));
  NormalEstimate last;
  for (const auto& sample : samples) last = estimator->update(sample);
  ASSERT_EQ(last.status, NormalStatus::tracked);
  bad.time = samples.back().time + 0.1;
  const auto after = estimator->update(bad);
  EXPECT_EQ(after.status, NormalStatus::held);
  if (after.covariance && GetParam().starts_with("s2")) {
    EXPECT_GT(after.covariance->trace(), last.covariance->trace());
  }
  EXPECT_NEAR(after.n.norm(), 1, 1e-9);
}

TEST_P(AnyEstimator, ForgetsOneFaceBeforeTheNext) {
  SlidingOptions options;
  options.seconds = 3;
  const RandomStream random(13);
  const auto path = sliding_path(Surface::flat, options, random);
  const auto estimator = make_normal_estimator(GetParam());
  for (const auto& sample : samples_along(path, options, random)) estimator->update(sample);
  // A second later and a decimetre off, the finger comes down on a face turned by 90 degrees.
  const Eigen::Matrix3d R =
      Eigen::AngleAxisd(std::numbers::pi / 2, Eigen::Vector3d::UnitX()).toRotationMatrix();
  NormalEstimate last;
  for (FingerSample sample : samples_along(path, options, random.fork("again"))) {
    sample.time += options.seconds + 1;
    sample.p = R * sample.p + Eigen::Vector3d(0.1, 0, 0);
    sample.f = R * sample.f;
    sample.tip_normal = R * sample.tip_normal.value();
    last = estimator->update(sample);
  }
  if (GetParam() == "rls-literal") return;  // its sign and start are left to chance
  EXPECT_LT(angle_between_deg(last.n, R * Eigen::Vector3d::UnitZ()), 30);
}

TEST(NormalEstimators, AnUnknownNameIsRefused) {
  EXPECT_THROW(make_normal_estimator("kalman"), BadInput);
}

TEST(NormalEstimators, OptionsOutOfRangeAreRefused) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(RlsEstimator({.decay = nan}), BadInput);
  EXPECT_THROW(RlsEstimator({.low_pass = 0}), BadInput);
  EXPECT_THROW(PlaneFitEstimator({.window = -1}), BadInput);
  EXPECT_THROW(EigenvectorEstimator({.distance = 0}), BadInput);
  EXPECT_THROW(S2Filter({.stay = 1}), BadInput);
  EXPECT_THROW(S2Smoother({.lag = nan}), BadInput);
}

TEST(NormalEstimators, OnAFlatFaceWithoutNoiseAllButTheLiteralFindTheNormal) {
  SlidingOptions exact;
  exact.force_noise = exact.point_noise = exact.tip_noise = 0;
  for (const std::string name : {"rls", "tls", "eigen", "s2", "s2-lag"}) {
    const auto score = score_of(name, Surface::flat, exact, 2);
    EXPECT_LT(median(score.error_deg), 1.5) << name;
  }
}

// Eqs 5.4-5.10 written out for two steps.
TEST(Rls, LiteralFollowsThePrintedEquations) {
  const std::vector<Eigen::Vector3d> p = {
      {0, 0, 0}, {0.001, 0, 0.0001}, {0.0015, 0.001, 0}, {0.003, 0.0012, 0.0002}};
  const Eigen::Vector3d f(0.4, -0.1, -1.7);
  const double dt = 0.01, beta = 1.3, K = 2000, g1 = 0.7, g2 = 1.1;
  RlsEstimator rls(
      {.literal = true, .decay = beta, .gain = K, .gamma1 = g1, .gamma2 = g2, .low_pass = 1});
  NormalEstimate estimate;
  for (std::size_t i = 0; i < p.size(); ++i) {
    FingerSample sample;
    sample.time = dt * static_cast<double>(i);
    sample.p = p[i];
    sample.f = f;
    estimate = rls.update(sample);
  }
  const auto v = [&](std::size_t i) -> Eigen::Vector3d { return (p[i + 1] - p[i]) / dt; };
  Eigen::Vector3d n = v(1).cross(v(0)).normalized();
  Eigen::Matrix3d L1 = Eigen::Matrix3d::Zero(), L2 = L1;
  for (std::size_t i : {1, 2}) {
    const Eigen::Vector3d grad = f.cross(v(i));
    L1 = L1 - beta * dt * L1 + dt * K / (1 + v(i).squaredNorm()) * v(i) * v(i).transpose();
    L2 = L2 - beta * dt * L2 + dt * K / (1 + grad.squaredNorm()) * grad * grad.transpose();
    const Eigen::Vector3d omega = n.cross(-(g1 * L1 + g2 * L2) * n);
    n = exp_so3(dt / 2 * omega) * n;
  }
  EXPECT_LT((estimate.n - n).norm(), 1e-12);
}

TEST(PlaneFit, CovarianceIsHonestOnAFlatFace) {
  const auto score = score_of("tls", Surface::flat, {.point_noise = 2e-5}, 20);
  EXPECT_NEAR(mean(score.nees), 2, 0.6);
}

struct Target {
  Surface surface;
  double median;
};

class S2Targets : public testing::TestWithParam<Target> {};
INSTANTIATE_TEST_SUITE_P(Surfaces, S2Targets,
                         testing::Values(Target{Surface::flat, 1.5}, Target{Surface::edge, 3.0},
                                         Target{Surface::smooth, 1.5},
                                         Target{Surface::corner, 3.0}));

TEST_P(S2Targets, AreMetWithoutBeingReportedTheNoise) {
  for (const std::string name : {"s2", "s2-lag"}) {
    const auto score = score_of(name, GetParam().surface, {});
    EXPECT_LE(median(score.error_deg), GetParam().median) << name;
    EXPECT_LE(quantile(score.error_deg, 0.95), 10) << name;
  }
}

TEST_P(S2Targets, HoldAtHalfAMillimetreOfPointNoise) {
  const auto score = score_of("s2", GetParam().surface, {.point_noise = 5e-4});
  EXPECT_LE(median(score.error_deg), 4);
}

TEST(S2Filter, CovarianceIsHonestOnAverage) {
  for (const double point_noise : {1e-4, 5e-4}) {
    double sum = 0;
    for (const Surface surface : kSurfaces) {
      sum += mean(score_of("s2", surface, {.point_noise = point_noise}, 20).nees);
    }
    EXPECT_NEAR(sum / 4, 2, 0.4) << point_noise;
  }
}

TEST(S2Smoother, CovarianceIsHonestOnAverageWithThePointNoiseOfAHand) {
  double sum = 0;
  for (const Surface surface : kSurfaces) {
    sum += mean(score_of("s2-lag", surface, {.point_noise = 2e-3}, 10).nees);
  }
  EXPECT_NEAR(sum / 4, 2, 0.4);
}

TEST(S2Filter, AnEdgeIsTwoFacesAndACornerThree) {
  EXPECT_EQ(find_faces(score_of("s2", Surface::flat, {}, 1).estimates).size(), 1u);
  const auto edge = find_faces(score_of("s2", Surface::edge, {}, 1).estimates);
  ASSERT_EQ(edge.size(), 2u);
  for (const Face& face : edge) EXPECT_GT(face.n.maxCoeff(), std::cos(0.05));
  EXPECT_EQ(find_faces(score_of("s2", Surface::corner, {}, 3).estimates).size(), 3u);
}

TEST(S2Filter, WithoutTipGeometryForceAndSlidingTellTheNormal) {
  SlidingOptions options;
  const RandomStream random(21);
  const auto path = sliding_path(Surface::flat, options, random);
  auto samples = samples_along(path, options, random);
  for (auto& sample : samples) sample.tip_normal.reset();
  S2Filter filter;
  SlidingScore score;
  add_score(filter, samples, path, options.period, score, 3.0);
  EXPECT_LT(median(score.error_deg), 5);
}

TEST(S2Filter, OutliersOfPointAndTipAreShrugged) {
  SlidingOptions options;
  RandomStream random(22);
  const auto path = sliding_path(Surface::smooth, options, random);
  auto samples = samples_along(path, options, random);
  for (std::size_t i = 0; i < samples.size(); i += 20) {
    samples[i].p += 0.004 * random.normal3();
    samples[i].tip_normal = random.unit_vector();
  }
  S2Filter filter;
  SlidingScore score;
  add_score(filter, samples, path, options.period, score);
  EXPECT_LT(median(score.error_deg), 3);
}

TEST(S2Filter, MissingSamplesAreBridged) {
  SlidingOptions options;
  RandomStream random(23);
  const auto path = sliding_path(Surface::smooth, options, random);
  std::vector<FingerSample> samples;
  for (const auto& sample : samples_along(path, options, random)) {
    if (random.uniform() > 0.3) samples.push_back(sample);
  }
  S2Filter filter;
  SlidingScore score;
  add_score(filter, samples, path, options.period, score);
  EXPECT_LT(median(score.error_deg), 1.5);
}

TEST(S2Smoother, IsBetterThanTheFilterAndSaysOfWhen) {
  const auto filtered = score_of("s2", Surface::flat, {}),
             smoothed = score_of("s2-lag", Surface::flat, {});
  EXPECT_LT(median(smoothed.error_deg), median(filtered.error_deg));
  SlidingOptions options;
  const RandomStream random(24);
  S2Smoother smoother({.lag = 0.1});
  for (const auto& sample :
       samples_along(sliding_path(Surface::flat, options, random), options, random)) {
    const auto estimate = smoother.update(sample);
    EXPECT_NEAR(estimate.time, sample.time - 0.1, 1e-9);
  }
}

// A finger that leaves one face and comes down on another has no information on the first.
TEST(S2Smoother, WhatComesAfterAGapDoesNotTurnWhatWasBefore) {
  SlidingOptions options;
  options.seconds = 2;
  const RandomStream random(25);
  const auto samples = samples_along(sliding_path(Surface::flat, options, random), options, random);
  const Eigen::Matrix3d R =
      Eigen::AngleAxisd(std::numbers::pi / 2, Eigen::Vector3d::UnitX()).toRotationMatrix();
  S2Smoother smoother;
  std::vector<double> reported;
  for (FingerSample sample : samples) {
    if (sample.time > 1 && sample.time < 1.3) continue;  // in the air
    if (sample.time > 1) {
      sample.p = R * sample.p;
      sample.f = R * sample.f;
      sample.tip_normal = R * sample.tip_normal.value();
    }
    const auto estimate = smoother.update(sample);
    if (estimate.status != NormalStatus::tracked) continue;
    reported.push_back(estimate.time);
    EXPECT_LT((estimate.covariance.value() * estimate.n).norm(), 1e-9) << estimate.time;
    const Eigen::Vector3d up = Eigen::Vector3d::UnitZ();
    const Eigen::Vector3d truth = estimate.time > 1 ? Eigen::Vector3d(R * up) : up;
    if (estimate.time > 0.5 && std::abs(estimate.time - 1.35) > 0.1) {
      EXPECT_LT(angle_between_deg(estimate.n, truth), 10) << estimate.time;
    }
  }
  for (std::size_t i = 1; i < reported.size(); ++i) EXPECT_GT(reported[i], reported[i - 1]);
}

}  // namespace
}  // namespace palpate::tactile
