// SPDX-License-Identifier: Apache-2.0
#include "palpate/core/random.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <numbers>
#include <set>
#include <vector>

namespace palpate {
namespace {

constexpr int kDraws = 100000;

// The golden values come from an independent implementation that itself reproduces the published
// outputs of xoshiro256++ for the state {1, 2, 3, 4} and of splitmix64 for the seed 1234567.
TEST(RandomStream, GoldenBits) {
  RandomStream plain(0);
  for (const std::uint64_t expected : {0x96bb3c9cab98ed3full, 0x65b64fbc9a770e81ull,
                                       0xed86fb2d91de1ae1ull, 0xc597f5e135156f81ull}) {
    EXPECT_EQ(plain.bits(), expected);
  }
  RandomStream named(42, "touch");
  for (const std::uint64_t expected : {0xca6ae733ec9e5545ull, 0xf67530662cb32cffull,
                                       0x2caa98de352cd9d8ull, 0x25e49e66ea09601full}) {
    EXPECT_EQ(named.bits(), expected);
  }
}

TEST(RandomStream, GoldenFork) {
  RandomStream fork = RandomStream(42, "touch").fork("noise", 3);
  for (const std::uint64_t expected : {0x870a1db6f09bb59dull, 0xa8d341eae15b5554ull,
                                       0x81a8a5e0f4a66f66ull, 0x1e9f6c0dac6d32a4ull}) {
    EXPECT_EQ(fork.bits(), expected);
  }
}

TEST(RandomStream, GoldenUniform) {
  RandomStream random(0);
  EXPECT_EQ(random.uniform(), 0.5887945063110213);
  EXPECT_EQ(random.uniform(), 0.39731310228895833);
  EXPECT_EQ(random.uniform(), 0.9278408991102584);
}

TEST(RandomStream, ForkNeitherAdvancesNorDependsOnDraws) {
  RandomStream used(7, "a"), fresh(7, "a");
  used.bits();
  EXPECT_EQ(used.fork("b", 1).bits(), fresh.fork("b", 1).bits());
  RandomStream untouched(7, "a");
  EXPECT_EQ(fresh.bits(), untouched.bits());
}

TEST(RandomStream, SeedsNamesAndIndicesGiveDifferentStreams) {
  std::set<std::uint64_t> first;
  std::size_t streams = 0;
  for (std::uint64_t seed = 0; seed < 50; ++seed) {
    for (const char* name : {"", "a", "b", "ab", "ba"}) {
      const RandomStream parent(seed, name);
      for (std::uint64_t index = 0; index < 20; ++index) {
        first.insert(parent.fork("x", index).bits());
        ++streams;
      }
    }
  }
  EXPECT_EQ(first.size(), streams);
}

TEST(RandomStream, UniformFillsItsRange) {
  RandomStream random(1);
  double sum = 0, lowest = 1, highest = 0;
  for (int i = 0; i < kDraws; ++i) {
    const double value = random.uniform();
    sum += value;
    lowest = std::min(lowest, value);
    highest = std::max(highest, value);
  }
  EXPECT_GE(lowest, 0.0);
  EXPECT_LT(highest, 1.0);
  EXPECT_LT(lowest, 1e-3);
  EXPECT_GT(highest, 1 - 1e-3);
  EXPECT_NEAR(sum / kDraws, 0.5, 5 * std::sqrt(1.0 / 12 / kDraws));
}

TEST(RandomStream, UniformBetweenStaysBetween) {
  RandomStream random(2);
  for (int i = 0; i < 1000; ++i) {
    const double value = random.uniform(-3.0, -1.0);
    EXPECT_GE(value, -3.0);
    EXPECT_LT(value, -1.0);
  }
}

TEST(RandomStream, NormalHasTheMomentsOfANormal) {
  RandomStream random(3);
  double sum = 0, squares = 0, fourth = 0;
  for (int i = 0; i < kDraws; ++i) {
    const double value = random.normal();
    ASSERT_TRUE(std::isfinite(value));
    sum += value;
    squares += value * value;
    fourth += value * value * value * value;
  }
  EXPECT_NEAR(sum / kDraws, 0.0, 5 / std::sqrt(kDraws));
  EXPECT_NEAR(squares / kDraws, 1.0, 5 * std::sqrt(2.0 / kDraws));
  EXPECT_NEAR(fourth / kDraws, 3.0, 5 * std::sqrt(96.0 / kDraws));
}

TEST(RandomStream, IndexIsUniform) {
  RandomStream random(4);
  std::array<int, 7> counts{};
  for (int i = 0; i < kDraws; ++i) ++counts.at(random.index(counts.size()));
  double chi_squared = 0;
  const double expected = kDraws / 7.0;
  for (const int count : counts) chi_squared += (count - expected) * (count - expected) / expected;
  EXPECT_LT(chi_squared, 22.46);  // 99.9 % quantile, 6 degrees of freedom
  EXPECT_EQ(random.index(1), 0u);
}

TEST(RandomStream, UnitVectorIsUniformOnTheSphere) {
  RandomStream random(5);
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  Eigen::Matrix3d second = Eigen::Matrix3d::Zero();
  for (int i = 0; i < kDraws; ++i) {
    const Eigen::Vector3d v = random.unit_vector();
    ASSERT_NEAR(v.norm(), 1.0, 1e-12);
    sum += v;
    second += v * v.transpose();
  }
  EXPECT_LT(sum.norm() / kDraws, 0.015);
  EXPECT_LT((second / kDraws - Eigen::Matrix3d::Identity() / 3).norm(), 0.015);
}

TEST(RandomStream, RotationIsUniformOnSO3) {
  RandomStream random(6);
  Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
  double angles = 0;
  for (int i = 0; i < kDraws; ++i) {
    const Eigen::Matrix3d R = random.rotation();
    ASSERT_LT((R * R.transpose() - Eigen::Matrix3d::Identity()).norm(), 1e-12);
    ASSERT_GT(R.determinant(), 0);
    sum += R;
    angles += std::acos(std::clamp((R.trace() - 1) / 2, -1.0, 1.0));
  }
  EXPECT_LT((sum / kDraws).norm(), 0.02);
  // The angle's density is (1 - cos a) / pi, its mean pi / 2 + 2 / pi.
  EXPECT_NEAR(angles / kDraws, std::numbers::pi / 2 + 2 / std::numbers::pi, 0.011);
}

}  // namespace
}  // namespace palpate
