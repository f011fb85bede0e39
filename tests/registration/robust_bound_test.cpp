// SPDX-License-Identifier: Apache-2.0
#include "palpate/registration/robust_bound.hpp"

#include <gtest/gtest.h>

#include "palpate/core/error.hpp"
#include "palpate/registration/registration.hpp"
#include "registration/problems.hpp"

namespace palpate::registration {
namespace {

using testing::make_problem;

constexpr double kBound = 0.004;
const RobustBoundOptions kEffort{.max_nodes = 20000, .max_seconds = 1e3};

TEST(RobustBound, HoldsForTheTruthAndCloses) {
  for (const double outliers : {0.3, 0.8}) {
    const auto problem = make_problem({.pairs = 100, .outliers = outliers, .noise = 0.001},
                                      RandomStream(1, "bound"));
    const auto result =
        register_correspondences(problem.correspondences, {.robust_bound = kEffort});
    ASSERT_TRUE(result.certificate.robust);
    const RobustBound& bound = *result.certificate.robust;
    const int found = static_cast<int>(result.inliers.size());
    EXPECT_TRUE(bound.is_exhausted);
    EXPECT_GE(bound.max_inliers, found);
    EXPECT_LT(bound.max_inliers, found + 20);
    EXPECT_LE(bound.min_cost, bound.cost);
    EXPECT_LE(bound.cost, 100 * kBound * kBound);
    EXPECT_DOUBLE_EQ(bound.min_cost, (100 - bound.max_inliers) * kBound * kBound);
  }
}

// A pose not known beforehand must be within the bound that starts from less.
TEST(RobustBound, CoversAPoseThatWasMissed) {
  const auto problem =
      make_problem({.pairs = 80, .outliers = 0.5, .noise = 0.0005}, RandomStream(2, "bound"));
  const RobustBound bound = bound_inliers(problem.correspondences, kBound, 3, kEffort);
  EXPECT_GE(bound.max_inliers, 40);
  EXPECT_TRUE(bound.is_exhausted);
}

// A mirror image keeps all distances, so that its pairs are a clique; but no rotation meets them.
TEST(RobustBound, RotationsExcludeAMirrorImage) {
  const auto problem = make_problem({.pairs = 60}, RandomStream(4, "bound"));
  Correspondences c = problem.correspondences;
  for (std::size_t i = 20; i < c.size(); ++i) c.target[i].x() = -c.target[i].x();
  const RobustBound bound = bound_inliers(c, kBound, 20, kEffort);
  EXPECT_GE(bound.max_inliers, 20);
  EXPECT_LT(bound.max_inliers, 40);
  EXPECT_GT(bound.nodes, 100);
  // Cliques alone.
  EXPECT_EQ(bound_inliers(c, kBound, 20, {.max_nodes = 1, .max_seconds = 1e3}).max_inliers, 40);
}

TEST(RobustBound, LessWorkLoosensIt) {
  const auto problem =
      make_problem({.pairs = 150, .outliers = 0.9, .noise = 0.001}, RandomStream(3, "bound"));
  const auto& c = problem.correspondences;
  const RobustBound full = bound_inliers(c, kBound, 15, kEffort),
                    little = bound_inliers(c, kBound, 15, {.max_nodes = 20, .max_seconds = 1e3}),
                    none = bound_inliers(c, kBound, 15, {.max_nodes = 1, .max_pairs = 100});
  EXPECT_LE(full.max_inliers, little.max_inliers);
  EXPECT_FALSE(little.is_exhausted);
  EXPECT_EQ(none.max_inliers, 150);
  EXPECT_THROW(bound_inliers(c, 0, 3, kEffort), BadInput);
}

// The work before the search for cliques looks at the clock, too: without time nothing is known.
TEST(RobustBound, WithoutTimeIsTheNumberOfPairs) {
  const auto problem =
      make_problem({.pairs = 200, .outliers = 0.5, .noise = 0.001}, RandomStream(5, "bound"));
  const RobustBound bound =
      bound_inliers(problem.correspondences, kBound, 3, {.max_nodes = 20000, .max_seconds = 0});
  EXPECT_EQ(bound.max_inliers, 200);
  EXPECT_EQ(bound.nodes, 0);
  EXPECT_FALSE(bound.is_exhausted);
}

}  // namespace
}  // namespace palpate::registration
