// SPDX-License-Identifier: Apache-2.0
#include "registration/pairing_rates.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numeric>

#include "palpate/registration/registration.hpp"
#include "registration/consensus.hpp"
#include "registration/false_alarm_test.hpp"
#include "registration/problems.hpp"

namespace palpate::registration {
namespace {

using testing::make_problem;

constexpr double kBound = 0.004;

/// Pairs of any source and any target that agree, joint ball of position and chord.
double agreements(const PairColumns& c, const Eigen::Isometry3d& T, double radius, double chord) {
  double count = 0;
  for (int i = 0; i < c.size(); ++i) {
    const Eigen::Vector3f p = T.cast<float>() * at(c.s, i);
    for (int j = 0; j < c.size(); ++j) {
      auto squares = static_cast<double>((p - at(c.t, j)).squaredNorm());
      if (chord > 0) {
        const Eigen::Vector3f n = T.linear().cast<float>() * at(c.n, i);
        squares += static_cast<double>((n - at(c.m, j)).squaredNorm()) / (chord * chord);
      }
      count += squares < radius * radius;
    }
  }
  return count;
}

TEST(PairingRates, CountAsABallOfThatRadius) {
  for (const bool normals : {false, true}) {
    const auto problem =
        make_problem({.pairs = 200, .outliers = 1, .box_outliers = true, .normals = normals},
                     RandomStream(1, "rates"));
    const double chord = chord_bound(problem.correspondences, normals ? 10 : 0);
    const Scorer scorer(problem.correspondences, kBound, chord);
    for (const double radius : {1.2, 1.6, 2.0}) {
      const PairingRates rates(scorer.columns(), chord, radius);
      EXPECT_NEAR(rates.coarseness(), 1, 1e-9);
      RandomStream random(2, "rates");
      double hits = 0, expected = 0;
      for (int k = 0; k < 300; ++k) {
        Eigen::Isometry3d T = rates.propose(random).T;
        // Away from the proposed pair, at which the cube and the ball differ.
        T.translation() += 3 * random.normal3();
        std::vector<int> counts;
        rates.agreements(T, {0, 1, 200}, counts);
        hits += std::accumulate(counts.begin(), counts.end(), 0.0);
        expected += agreements(scorer.columns(), T, radius, chord);
      }
      ASSERT_GT(expected, 50);
      EXPECT_NEAR(hits / expected, 1, 5 * std::sqrt(2 / expected)) << normals << " " << radius;
    }
  }
}

TEST(PairingRates, ProposalsMakeAPairAgree) {
  for (const bool normals : {false, true}) {
    const auto problem =
        make_problem({.pairs = 60, .outliers = 1, .normals = normals}, RandomStream(3, "rates"));
    const double chord = chord_bound(problem.correspondences, normals ? 5 : 0);
    const Scorer scorer(problem.correspondences, kBound, chord);
    const PairingRates rates(scorer.columns(), chord, 1);
    RandomStream random(4, "rates");
    for (int k = 0; k < 100; ++k) {
      const auto [T, source, weight] = rates.propose(random);
      EXPECT_EQ(weight, 1);
      EXPECT_LT((T.linear() * T.linear().transpose() - Eigen::Matrix3d::Identity()).norm(), 1e-6);
      EXPECT_NEAR(T.linear().determinant(), 1, 1e-6);
      double nearest = 1e9;
      for (int j = 0; j < scorer.size(); ++j) {
        const Eigen::Vector3d p = T * at(scorer.columns().s, source).cast<double>();
        const Eigen::Vector3d q = at(scorer.columns().t, j).cast<double>();
        double chords = 0;
        if (normals) {
          const Eigen::Vector3d n = T.linear() * at(scorer.columns().n, source).cast<double>();
          chords = (n - at(scorer.columns().m, j).cast<double>()).norm() / chord;
        }
        nearest = std::min(nearest, std::max((p - q).norm(), chords));
      }
      EXPECT_LT(nearest, 1.5);  // half the cube's diagonal is 1.4
    }
  }
}

TEST(PairingRates, CloudsLargeForTheRadiusGetACoarseGrid) {
  const auto problem = make_problem({.pairs = 50, .outliers = 1}, RandomStream(5, "rates"));
  const Scorer scorer(problem.correspondences, 1e-9, 0);
  const PairingRates rates(scorer.columns(), 0, 1);
  EXPECT_GT(rates.coarseness(), 1e6);
  RandomStream random(6, "rates");
  const ProposedPose pose = rates.propose(random);
  std::vector<int> counts;
  rates.agreements(pose.T, {pose.source, 1, 50}, counts);
  EXPECT_LE(counts.size(), 50u);
}

// Counted in cells of a small cloud, far places exceed every int along one axis and lie within the
// grid along the others.
TEST(PairingRates, FarSourcesAgreeWithNothing) {
  const auto problem = make_problem({.pairs = 50, .outliers = 1}, RandomStream(5, "rates"));
  for (int axis = 0; axis < 3; ++axis) {
    for (const double size : {1.0, 1e-5, 0.0}) {
      auto far = problem.correspondences;
      for (auto& p : far.target) p *= size;
      far.source = far.target;
      for (std::size_t i = 0; i < 50; ++i) far.source[i][axis] += i % 2 == 0 ? 1e6 : -1e6;
      const Scorer scorer(far, 1e-9, 0);
      const PairingRates rates(scorer.columns(), 0, 1);
      std::vector<int> counts;
      rates.agreements(Eigen::Isometry3d::Identity(), {0, 1, 50}, counts);
      EXPECT_TRUE(counts.empty()) << axis << " " << size;
    }
  }
}

TEST(PowerOfMean, IsTheMeanProductOfDifferentCounts) {
  // Of 2, 3, 5 and 0: all pairs and all triples.
  EXPECT_NEAR(power_of_mean({2, 3, 5}, 4, 1), 10.0 / 4, 1e-12);
  EXPECT_NEAR(power_of_mean({2, 3, 5}, 4, 2), (6 + 10 + 15) / 6.0, 1e-12);
  EXPECT_NEAR(power_of_mean({2, 3, 5}, 4, 3), 30 / 4.0, 1e-12);
  EXPECT_EQ(power_of_mean({2, 3, 5}, 4, 4), 0);
  // Counts that come in clumps of 3.
  RandomStream random(9, "counts");
  double sum = 0;
  constexpr int kRuns = 40000;
  for (int run = 0; run < kRuns; ++run) {
    std::vector<int> counts;
    for (int i = 0; i < 30; ++i) {
      if (random.uniform() < 0.2) counts.push_back(3);
    }
    sum += power_of_mean(counts, 30, 4);
  }
  EXPECT_NEAR(sum / kRuns, std::pow(0.6, 4), 0.03 * std::pow(0.6, 4));
}

// Many at a time agree as each alone, from the start again past the end.
TEST(PairingRates, AgreementsOfManySourcesAreThoseOfEach) {
  for (const bool normals : {false, true}) {
    const auto problem =
        make_problem({.pairs = 700, .outliers = 1, .normals = normals}, RandomStream(3, "rates"));
    const double chord = chord_bound(problem.correspondences, normals ? 10 : 0);
    const Scorer scorer(problem.correspondences, kBound, chord);
    const PairingRates rates(scorer.columns(), chord, 1.5);
    RandomStream random(4, "rates");
    int some = 0;
    for (int k = 0; k < 20; ++k) {
      const Eigen::Isometry3d T = rates.propose(random).T;
      const Strided sources{650 - 30 * k, 1 + k % 3, 520};
      std::vector<int> together, each;
      rates.agreements(T, sources, together);
      for (int i = 0; i < sources.count; ++i) {
        rates.agreements(T, {(sources.first + i * sources.step) % 700, 1, 1}, each);
      }
      EXPECT_EQ(together, each) << normals << " " << k;
      some += static_cast<int>(each.size());
    }
    EXPECT_GT(some, 20);
  }
}

TEST(FalseAlarmTest, CopiesAreNoEvidence) {
  auto problem =
      make_problem({.pairs = 200, .outliers = 0.97, .noise = 0.001}, RandomStream(7, "rates"));
  auto& c = problem.correspondences;
  const RandomStream random(8, "rates");
  const auto estimated = [&] {
    const Scorer scorer(c, kBound, 0);
    return FalseAlarmTest(scorer, 0.01, {.reach = 3, .copies = 2}, random)
        .exact(scorer.centred(problem.truth));
  };
  const double once = estimated();
  for (int copies = 0; copies < 2; ++copies) {
    for (std::size_t i = 0; i < 200; ++i) {
      c.source.push_back(c.source[i]);
      c.target.push_back(c.target[i]);
    }
  }
  EXPECT_GT(once, 0);
  EXPECT_GE(estimated(), once);
}

// Where some poses gather more than is tolerated of all of them, the rest need not be looked at.
TEST(FalseAlarmTest, FewerPosesRefuseTheSame) {
  constexpr double kTolerated = 0.01;
  constexpr FalseAlarmTest::Effort kMany{2048, 512};
  int refused = 0, sooner = 0;
  for (std::uint64_t seed = 0; seed < 64; ++seed) {
    const auto problem = testing::make_problem(
        {.outliers = seed % 2 ? 1 : 0.995, .noise = 0.001, .normal_deg = 5, .normals = true},
        RandomStream(seed, "false alarms"));
    const auto& c = problem.correspondences;
    const auto best = register_correspondences(c, {.normal_noise_deg = 5, .best_effort = true});
    if (!best.T_target_source) continue;
    const Scorer scorer(c, 0.004, chord_bound(c, 5), {});
    const Eigen::Isometry3d T = scorer.centred(*best.T_target_source);
    const RandomStream random(seed, "judge");
    FalseAlarmTest all(scorer, kTolerated, {}, random), some(scorer, kTolerated, {}, random);
    const double by_all = all.estimate(T, kMany), by_some = some.estimate(T, kMany, kTolerated);
    EXPECT_EQ(by_some > kTolerated, by_all > kTolerated) << seed;
    EXPECT_TRUE(by_all > kTolerated || by_some == by_all) << seed;
    refused += by_all > kTolerated;
    sooner += by_some != by_all;
  }
  EXPECT_GE(refused, 12);
  EXPECT_GE(64 - refused, 12);
  EXPECT_GE(sooner, 2);
}

}  // namespace
}  // namespace palpate::registration
