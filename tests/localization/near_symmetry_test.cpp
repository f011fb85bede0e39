// SPDX-License-Identifier: Apache-2.0
// A difference between two poses that is below the error of the mesh decides nothing.
#include <gtest/gtest.h>

#include <array>
#include <string>
#include <utility>
#include <vector>

#include "localization/scenes.hpp"

namespace palpate::localization {
namespace {

constexpr double kStep = 0.0001;  // m; Evidence::surface_sigma is 0.3 mm

/// A block of 50 x 40 x 80 mm whose top is higher by the step on one half, so that half turns keep
/// it but for that.
geometry::TriangleMesh stepped_block(double step) {
  constexpr int kCorners = 6;
  const std::array<std::pair<double, double>, kCorners> profile = {{{-0.025, -0.04},
                                                                    {0.025, -0.04},
                                                                    {0.025, 0.04 + step},
                                                                    {0, 0.04 + step},
                                                                    {0, 0.04},
                                                                    {-0.025, 0.04}}};
  geometry::TriangleMesh mesh;
  for (const double y : {-0.02, 0.02}) {
    for (const auto& [x, z] : profile) mesh.vertices.emplace_back(x, y, z);
  }
  for (const auto& [a, b, c] : {std::array{0, 1, 4}, {1, 2, 3}, {1, 3, 4}, {0, 4, 5}}) {
    mesh.triangles.push_back({a, b, c});  // counter-clockwise in x and z, seen from -y
    mesh.triangles.push_back({a + kCorners, c + kCorners, b + kCorners});
  }
  for (int i = 0; i < kCorners; ++i) {
    const int next = (i + 1) % kCorners;
    mesh.triangles.push_back({i, i + kCorners, next + kCorners});
    mesh.triangles.push_back({i, next + kCorners, next});
  }
  return mesh;
}

geometry::KnownObject block() {
  return geometry::make_known_object("stepped block", stepped_block(kStep), 0.2);
}

/// Contacts nearly without noise, and known to be, on up to three sides.
Scene scene_of(const geometry::ObjectModel& model, int contacts, std::uint64_t seed) {
  SceneOptions options;
  options.contacts = contacts;
  options.point_noise = 0.00001;
  options.normal_noise = 0.01;
  Scene scene = make_scene(model, options, RandomStream(seed, "stepped"));
  for (auto& contact : scene.evidence.contacts) contact.point_sigma = options.point_noise;
  return scene;
}

TEST(NearSymmetry, TurnsThatDifferByLessThanTheToleranceAreOnePose) {
  EXPECT_EQ(block().symmetries.size(), 4U);
}

/// As if the turns were distinguished: then a side must not be stated.
TEST(NearSymmetry, AStepBelowTheErrorOfTheSurfaceDecidesNothing) {
  geometry::KnownObject object = block();
  object.symmetries = {Eigen::Matrix3d::Identity()};
  const geometry::ObjectModel model(std::move(object));
  for (const int contacts : {20, 60}) {
    for (std::uint64_t seed = 0; seed < 5; ++seed) {
      const Scene scene = scene_of(model, contacts, seed);
      for (const bool fast : {true, false}) {
        const RandomStream random(seed, "search");
        const Posterior posterior = fast ? localize_fast(model, scene.evidence, random)
                                         : localize(model, scene.evidence, random);
        EXPECT_EQ(posterior.status, PoseStatus::ambiguous)
            << contacts << " contacts, seed " << seed << ", fast " << fast << ": "
            << best_probability(posterior);
      }
    }
  }
}

}  // namespace
}  // namespace palpate::localization
