// SPDX-License-Identifier: Apache-2.0
#include "consistency_graph.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "palpate/core/error.hpp"
#include "registration/problems.hpp"

namespace palpate::registration {
namespace {

using testing::make_problem;

constexpr double kBound = 0.004;

TEST(ConsistencyGraph, JoinsPairsOfEqualLength) {
  for (const std::size_t pairs : {2u, 63u, 64u, 65u, 200u}) {
    const auto problem = make_problem({.pairs = pairs, .outliers = 0.6, .noise = 0.001},
                                      RandomStream(pairs, "graph"));
    const auto& c = problem.correspondences;
    const ConsistencyGraph graph(c, {.noise_bound = kBound});
    const double tolerance = 1.25 * kBound, margin = 1e-3 * kBound;
    int edges = 0;
    for (int i = 0; i < graph.size(); ++i) {
      int degree = 0;
      for (int j = 0; j < graph.size(); ++j) {
        const auto a = static_cast<std::size_t>(i), b = static_cast<std::size_t>(j);
        const double length = (c.source[a] - c.source[b]).norm();
        const double off = std::abs(length - (c.target[a] - c.target[b]).norm());
        degree += graph.joined(i, j);
        EXPECT_EQ(graph.joined(i, j), graph.joined(j, i));
        if (std::abs(off - tolerance) < margin || std::abs(length - tolerance) < margin) continue;
        EXPECT_EQ(graph.joined(i, j), i != j && off < tolerance && length > tolerance);
      }
      EXPECT_EQ(graph.degree(i), degree);
      edges += degree;
    }
    const double n = graph.size();
    EXPECT_NEAR(graph.density(), edges / (n * (n - 1)), 1e-12);
  }
}

TEST(ConsistencyGraph, NormalsKeepInliersAndDropMostOthers) {
  const auto problem = make_problem(
      {.pairs = 300, .outliers = 0.5, .noise = 0.001, .normal_deg = 5, .normals = true},
      RandomStream(1, "graph"));
  const ConsistencyGraph lengths(problem.correspondences, {.noise_bound = kBound});
  const ConsistencyGraph both(problem.correspondences,
                              {.noise_bound = kBound, .normal_noise_deg = 5});
  int inlier_edges[2] = {0, 0}, other_edges[2] = {0, 0};
  for (int i = 0; i < 300; ++i) {
    for (int j = 0; j < i; ++j) {
      const bool inliers = problem.inlier[static_cast<std::size_t>(i)] &&
                           problem.inlier[static_cast<std::size_t>(j)];
      EXPECT_LE(both.joined(i, j), lengths.joined(i, j));
      (inliers ? inlier_edges : other_edges)[0] += lengths.joined(i, j);
      (inliers ? inlier_edges : other_edges)[1] += both.joined(i, j);
    }
  }
  EXPECT_GT(inlier_edges[1], 0.98 * inlier_edges[0]);
  EXPECT_LT(other_edges[1], 0.25 * other_edges[0]);
}

TEST(Clique, IsACliqueAndFindsTheInliers) {
  const auto problem =
      make_problem({.pairs = 200, .outliers = 0.9, .noise = 0.001}, RandomStream(2, "graph"));
  const ConsistencyGraph graph(problem.correspondences, {.noise_bound = kBound});
  std::size_t largest = 0;
  for (int seed = 0; seed < graph.size(); ++seed) {
    const auto clique = grow_clique(graph, seed, 100);
    EXPECT_EQ(clique.front(), seed);
    int inliers = 0;
    for (const int i : clique) {
      inliers += problem.inlier[static_cast<std::size_t>(i)];
      for (const int j : clique) EXPECT_TRUE(i == j || graph.joined(i, j));
    }
    if (clique.size() > largest) {
      largest = clique.size();
      EXPECT_TRUE(largest < 12 || inliers > 11);
    }
    EXPECT_LE(grow_clique(graph, seed, 5).size(), 5u);
  }
  EXPECT_GE(largest, 14u);
}

TEST(ConsistencyGraph, BadInput) {
  const auto problem = make_problem({.pairs = 5}, RandomStream(3, "graph"));
  EXPECT_THROW(ConsistencyGraph(problem.correspondences, {.noise_bound = 0}), BadInput);
  EXPECT_THROW(ConsistencyGraph(problem.correspondences, {.length_tolerance = -1}), BadInput);
  EXPECT_EQ(ConsistencyGraph({}, {}).size(), 0);
}

}  // namespace
}  // namespace palpate::registration
