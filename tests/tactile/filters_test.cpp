// SPDX-License-Identifier: Apache-2.0
#include "tactile/normals/filters.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "palpate/core/error.hpp"
#include "palpate/core/random.hpp"
#include "tactile/normals/noise_meter.hpp"

namespace palpate::tactile {
namespace {

TEST(RollingMean, IsTheMeanOfTheLastHundred) {
  RollingMean filter(100);
  RandomStream random(1);
  std::vector<Eigen::Vector3d> values;
  for (int i = 0; i < 350; ++i) {
    values.push_back(random.normal3());
    const Eigen::Vector3d filtered = filter.add(values.back());
    Eigen::Vector3d mean = Eigen::Vector3d::Zero();
    const std::size_t count = std::min<std::size_t>(values.size(), 100);
    for (std::size_t k = values.size() - count; k < values.size(); ++k) {
      mean += values[k] / static_cast<double>(count);
    }
    EXPECT_TRUE(filtered.isApprox(mean, 1e-12)) << i;
  }
  EXPECT_TRUE(filter.full());
  filter.clear();
  EXPECT_TRUE(filter.add(Eigen::Vector3d::UnitX()).isApprox(Eigen::Vector3d::UnitX()));
}

TEST(RollingMean, NeedsAWindow) { EXPECT_THROW(RollingMean(0), BadInput); }

TEST(ExponentialDecay, AStepHasComeThroughBy63PercentAfterTheTimeConstant) {
  for (double dt : {0.001, 0.01, 0.05}) {
    ExponentialDecay filter(0.2);
    filter.add(Eigen::Vector3d::Zero(), dt);
    Eigen::Vector3d y;
    for (double t = dt; t < 0.2 + dt / 2; t += dt) y = filter.add(Eigen::Vector3d::Ones(), dt);
    EXPECT_NEAR(y.x(), 1 - std::exp(-1), 1e-9) << dt;
  }
}

TEST(ExponentialDecay, StartsAtTheFirstValueAndNeedsATimeConstant) {
  ExponentialDecay filter(1);
  EXPECT_TRUE(filter.add({1, 2, 3}, 0.01).isApprox(Eigen::Vector3d(1, 2, 3)));
  EXPECT_THROW(ExponentialDecay(0), BadInput);
}

TEST(NoiseMeter, MeasuresWhiteNoiseOnAMovingSignal) {
  constexpr double kSigma = 0.3;
  RandomStream random(2);
  NoiseMeter meter(3, 10 * kSigma, 1e-6, 400);
  for (int i = 0; i < 5000; ++i) {
    const double t = 0.01 * i;
    meter.add(Eigen::Vector3d(std::sin(t), t, 5) + kSigma * random.normal3());
  }
  EXPECT_NEAR(meter.sigma(), kSigma, 0.1 * kSigma);  // of 400 samples, 3 axes: +-4 %
}

TEST(NoiseMeter, NeverReportsLessThanTheLeast) {
  NoiseMeter meter(3, 1, 0.05, 50);
  for (int i = 0; i < 500; ++i) meter.add(Eigen::Vector3d::Zero());
  EXPECT_EQ(meter.sigma(), 0.05);
}

TEST(NoiseMeter, JumpsAreNoNoise) {
  RandomStream random(3);
  NoiseMeter meter(3, 0.1, 1e-6, 100);
  for (int i = 0; i < 2000; ++i) {
    meter.add(Eigen::Vector3d::Constant(i / 100) + 0.1 * random.normal3());  // 20 steps of 1
  }
  EXPECT_LT(meter.sigma(), 0.125);
}

}  // namespace
}  // namespace palpate::tactile
