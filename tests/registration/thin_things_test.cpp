// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "palpate/geometry/objects/shapes.hpp"
#include "palpate/registration/registration.hpp"
#include "registration/consensus.hpp"
#include "registration/pairing_rates.hpp"
#include "registration/problems.hpp"
#include "registration/scorer.hpp"

namespace palpate::registration {
namespace {

constexpr double kBound = 0.004;

struct Thin {
  const char* name;
  Eigen::Vector3d size;
};

const Thin kPencil{"pencil", {0.18, 0.008, 0.008}}, kRuler{"ruler", {0.3, 0.03, 0.002}},
    kSheet{"sheet", {0.2, 0.15, 0.002}};

testing::Problem problem_of(const Thin& thing, double outliers, bool normals, std::uint64_t seed) {
  const auto mesh = geometry::box_mesh(thing.size);
  return testing::make_problem({.outliers = outliers,
                                .noise = kBound / 4,
                                .normal_deg = 5,
                                .normals = normals,
                                .mesh = &mesh},
                               RandomStream(seed, "thin"));
}

/// Wrong pairs alone: without those that are right to within twice the bound by accident.
Correspondences wrong_pairs(const Thin& thing, std::uint64_t seed) {
  const auto problem = problem_of(thing, 1, false, seed);
  const auto& c = problem.correspondences;
  std::vector<int> wrong;
  for (std::size_t i = 0; i < c.size(); ++i) {
    const double off = (problem.truth * c.source[i] - c.target[i]).norm();
    if (off >= 2 * kBound) wrong.push_back(static_cast<int>(i));
  }
  return subset(c, wrong);
}

// Where two long or two flat things lie on one another much agrees, at so few poses that poses at
// random do not show it: of 100 pencils 28 had a pose, of rulers 38, of sheets 19.
TEST(ThinThings, LieOnOneAnotherByChance) {
  constexpr int kRuns = 50;
  for (const auto& thing : {kPencil, kRuler, kSheet}) {
    int found = 0;
    for (std::uint64_t seed = 0; seed < kRuns; ++seed) {
      found += register_correspondences(wrong_pairs(thing, seed), {.noise_bound = kBound})
                   .T_target_source.has_value();
    }
    EXPECT_LE(found, 3) << thing.name;
  }
}

TEST(ThinThings, HaveAPoseAllTheSame) {
  for (const auto& thing : {kPencil, kRuler, kSheet}) {
    for (std::uint64_t seed = 0; seed < 5; ++seed) {
      const auto problem = problem_of(thing, 0.8, false, seed);
      const auto result =
          register_correspondences(problem.correspondences, {.noise_bound = kBound});
      ASSERT_TRUE(result.T_target_source) << thing.name << " " << seed;
      const Eigen::Isometry3d off = problem.truth.inverse() * *result.T_target_source;
      for (const auto& p : problem.correspondences.source) {
        EXPECT_LT((off * p - p).norm(), kBound) << thing.name << " " << seed;
      }
    }
  }
}

// Poses that lay things on one another are proposed more often than chance would, and weigh less.
TEST(ThinThings, WeightsMakeUpForWhatIsProposedMoreOften) {
  constexpr int kPoses = 20000;
  constexpr double kAngle = 10 * std::numbers::pi / 180;
  for (const bool normals : {false, true}) {
    const auto problem = problem_of(kPencil, 1, normals, 3);
    const double chord = chord_bound(problem.correspondences, normals ? 5 : 0);
    const Scorer scorer(problem.correspondences, kBound, chord);
    const PairingRates rates(scorer.columns(), chord, 1, thin_axes(scorer.columns()));
    const Eigen::Vector3d along = problem.truth.linear().col(0);
    RandomStream random(5, "thin");
    double sum = 0, aligned = 0, aligned_sum = 0;
    for (int k = 0; k < kPoses; ++k) {
      const ProposedPose pose = rates.propose(random);
      const bool is_aligned = std::abs(pose.T.linear().col(0).dot(along)) > std::cos(kAngle);
      sum += pose.weight;
      aligned += is_aligned;
      aligned_sum += is_aligned ? pose.weight : 0;
    }
    EXPECT_NEAR(sum / kPoses, 1, 0.03) << normals;
    if (normals) continue;
    const double by_chance = 1 - std::cos(kAngle);
    EXPECT_NEAR(aligned_sum / kPoses, by_chance, 0.1 * by_chance);
    EXPECT_GT(aligned / kPoses, 10 * by_chance);
  }
}

}  // namespace
}  // namespace palpate::registration
