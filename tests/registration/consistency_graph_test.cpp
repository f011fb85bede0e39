// SPDX-License-Identifier: Apache-2.0
#include "palpate/registration/consistency_graph.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "palpate/core/error.hpp"
#include "palpate/registration/chance.hpp"
#include "problems.hpp"

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
    const double tolerance = 1.25 * kBound, doubt = 1e-3 * kBound;
    int edges = 0;
    for (int i = 0; i < graph.size(); ++i) {
      int degree = 0;
      for (int j = 0; j < graph.size(); ++j) {
        const auto a = static_cast<std::size_t>(i), b = static_cast<std::size_t>(j);
        const double length = (c.source[a] - c.source[b]).norm();
        const double off = std::abs(length - (c.target[a] - c.target[b]).norm());
        degree += graph.joined(i, j);
        EXPECT_EQ(graph.joined(i, j), graph.joined(j, i));
        if (std::abs(off - tolerance) < doubt || std::abs(length - tolerance) < doubt) continue;
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

// The tail against what a simulation of the model gives.
TEST(Chance, TailAgreesWithSimulation) {
  RandomStream random(4, "chance");
  for (const int dimensions : {3, 5}) {
    const double rate = 1.5;
    constexpr int kDraws = 200000;
    int beyond[3] = {0, 0, 0};
    const double gains[3] = {0.5, 1.5, 2.5};
    for (int draw = 0; draw < kDraws; ++draw) {
      double sum = 0;
      for (double time = -std::log(1 - random.uniform()); time < rate;
           time -= std::log(1 - random.uniform())) {
        sum += 1 - std::pow(random.uniform(), 2.0 / dimensions);
      }
      for (int k = 0; k < 3; ++k) beyond[k] += sum >= gains[k];
    }
    for (int k = 0; k < 3; ++k) {
      const double simulated = static_cast<double>(beyond[k]) / kDraws;
      const double computed = expected_by_chance({1, rate, dimensions}, gains[k]);
      EXPECT_GT(computed, 0.95 * simulated);
      EXPECT_LT(computed, 1.5 * simulated + 1e-4);  // gains are rounded up
    }
  }
}

TEST(Chance, FallsWithGainAndGrowsWithRate) {
  double last = 2;
  for (double gain = 0; gain < 60; gain += 0.7) {
    const double expected = expected_by_chance({1, 2.0, 3}, gain);
    EXPECT_LE(expected, 10 * last);  // from the exact tail to its bound is a step up
    EXPECT_LE(expected, expected_by_chance({1, 3.0, 3}, gain));
    last = expected;
  }
  EXPECT_LT(last, 1e-40);
  EXPECT_EQ(expected_by_chance({7, 2.0, 3}, 0), 7);
}

}  // namespace
}  // namespace palpate::registration
