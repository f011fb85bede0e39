// SPDX-License-Identifier: Apache-2.0
#include "representations.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "palpate/core/error.hpp"
#include "palpate/core/statistics.hpp"
#include "simulation/scenes.hpp"

namespace palpate::app {
namespace {

using simulation::cuboid;
using simulation::trough;

constexpr double kRadius = 0.007, kDepth = 0.0002;  // m

std::vector<TestSphere> probes_on(const geometry::MeshQuery& mesh) {
  return place_test_spheres(mesh, 60, kRadius, kDepth, RandomStream(1, "probes"));
}

TEST(Representations, ProbesTouchTheTrueSurface) {
  const geometry::MeshQuery mesh(trough().mesh);
  const auto probes = probes_on(mesh);
  ASSERT_EQ(probes.size(), 60u);
  for (const TestSphere& probe : probes) {
    EXPECT_NEAR((probe.center - probe.touch.point).norm(), kRadius - kDepth, 2.1e-6);
    EXPECT_FALSE(mesh.inside(probe.center));
  }
}

TEST(Representations, TheTrueSurfaceIsMetExactly) {
  const geometry::MeshQuery mesh(trough().mesh);
  const auto result = measure_representation(Representation::exact, mesh, probes_on(mesh), kRadius);
  EXPECT_EQ(result.missed, 0);
  EXPECT_LT(*std::max_element(result.offsets.begin(), result.offsets.end()), 1e-6);
  EXPECT_LT(median(result.angles), 1e-6);
  EXPECT_NEAR(median(result.depths), kDepth, 2e-6);
}

TEST(Representations, TheHullCoversHollows) {
  const geometry::MeshQuery mesh(trough().mesh);
  const auto probes = probes_on(mesh);
  const auto hull = measure_representation(Representation::hull, mesh, probes, kRadius);
  EXPECT_GT(quantile(hull.depths, 1), 10 * kDepth);
  EXPECT_GT(quantile(hull.offsets, 1), 0.001);
}

TEST(Representations, AConvexObjectIsWellMetByAll) {
  const geometry::MeshQuery mesh(cuboid({0.05, 0.06, 0.07}, 0.1).mesh);
  const auto probes = probes_on(mesh);
  for (const Representation representation : kRepresentations) {
    const auto result = measure_representation(representation, mesh, probes, kRadius);
    EXPECT_LE(result.missed, 3) << to_string(representation);
    EXPECT_LT(median(result.angles), 0.01) << to_string(representation);
    EXPECT_LT(median(result.offsets), 0.0005) << to_string(representation);
  }
}

TEST(Representations, RejectsProbesThatCannotBe) {
  const geometry::MeshQuery mesh(trough().mesh);
  EXPECT_THROW(place_test_spheres(mesh, 0, kRadius, kDepth, RandomStream(1)), BadInput);
  EXPECT_THROW(place_test_spheres(mesh, 5, kRadius, 0.01, RandomStream(1)), BadInput);
  EXPECT_THROW(measure_representation(Representation::hull, mesh, {}, kRadius), BadInput);
}

}  // namespace
}  // namespace palpate::app
