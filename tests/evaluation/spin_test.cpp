// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "evaluation/quick_options.hpp"
#include "palpate/evaluation/trial.hpp"

namespace palpate::evaluation {
namespace {

constexpr std::uint64_t kSeed = 4;
constexpr int kSides = 96, kRings = 25;

/// A tapered roller, out of round by 1.2 mm: its spin makes little difference to any touch.
geometry::TriangleMesh roller() {
  constexpr double kLength = 0.12;
  geometry::TriangleMesh mesh;
  for (int ring = 0; ring < kRings; ++ring) {
    const double along = static_cast<double>(ring) / (kRings - 1);
    for (int i = 0; i < kSides; ++i) {
      const double angle = 2 * std::numbers::pi * i / kSides;
      const double radius = 0.022 + 0.006 * along + 0.0012 * std::cos(3 * angle);
      mesh.vertices.emplace_back(kLength * (along - 0.5), radius * std::cos(angle),
                                 radius * std::sin(angle));
    }
  }
  const int ends = kRings * kSides;
  mesh.vertices.emplace_back(-kLength / 2, 0, 0);
  mesh.vertices.emplace_back(kLength / 2, 0, 0);
  for (int i = 0; i < kSides; ++i) {
    const int next = (i + 1) % kSides;
    for (int base = 0; base + kSides < ends; base += kSides) {
      mesh.triangles.push_back({base + i, base + next, base + kSides + i});
      mesh.triangles.push_back({base + next, base + kSides + next, base + kSides + i});
    }
    mesh.triangles.push_back({next, i, ends});
    mesh.triangles.push_back({ends - kSides + i, ends - kSides + next, ends + 1});
  }
  return mesh;
}

/// Another attempt would add no information on it.
TEST(Trial, KeepsWhatItHoldsWhereOnlyTheSpinIsUnknown) {
  TrialOptions options;
  options.pick.estimation.search = quick_options().pick.estimation.search;
  options.start.stable_pose = 0;
  const geometry::ObjectModel object(geometry::make_known_object("roller", roller(), 0.2));
  const Trial trial = run_trial(object, options, kSeed);
  ASSERT_TRUE(trial.metrics.lifted);
  ASSERT_TRUE(trial.metrics.has_pose);
  EXPECT_LT(trial.metrics.probability, 0.5);
  EXPECT_GT(trial.metrics.free_extent, 0.2);
  EXPECT_EQ(trial.result.attempts, 1);
  EXPECT_EQ(trial.result.regrasps, 0);
}

}  // namespace
}  // namespace palpate::evaluation
