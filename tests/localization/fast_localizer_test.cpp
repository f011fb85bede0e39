// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>

#include "localization/scenes.hpp"
#include "palpate/localization/localizer.hpp"

namespace palpate::localization {
namespace {

TEST(LocalizeFast, FindsThePoseOfExactContacts) {
  SceneOptions options;
  options.contacts = 20;
  options.point_noise = options.normal_noise = 0;
  for (const char* name : {"bottle", "bracket", "bunny"}) {
    const geometry::ObjectModel& model = model_of(name);
    const Scene scene = make_scene(model, options, RandomStream(2));
    const Posterior posterior = localize_fast(model, scene.evidence, RandomStream(1));
    ASSERT_FALSE(posterior.modes.empty()) << name;
    const auto error =
        pose_error(posterior.modes[0].T_frame_object, scene.truth, model.object().symmetries);
    EXPECT_LT(error.rotation, 0.02) << name;
    EXPECT_LT(error.translation, 0.001) << name;
  }
}

TEST(LocalizeFast, LeavesWhatIsOpenToTheFullSearch) {
  SceneOptions options;
  options.contacts = 2;
  const geometry::ObjectModel& model = model_of("box");
  const Scene scene = make_scene(model, options, RandomStream(1));
  LocalizerOptions quick;
  quick.proposals = 10000;
  quick.particles = 200;
  EXPECT_EQ(localize_fast(model, scene.evidence, RandomStream(1), quick).status,
            PoseStatus::ambiguous);
}

TEST(LocalizeFast, AnotherObjectsContactsGiveNoPose) {
  SceneOptions options;
  options.contacts = 20;
  const Scene scene = make_scene(model_of("bunny"), options, RandomStream(3));
  EXPECT_EQ(localize_fast(model_of("box"), scene.evidence, RandomStream(1)).status,
            PoseStatus::no_pose);
}

/// A can, round, with a foot that is 6 mm narrower.
geometry::KnownObject can() {
  constexpr int kSides = 200;
  const double profile[][2] = {{0.028, 0}, {0.034, 0.02}, {0.034, 0.1}};  // radius, height, m
  geometry::TriangleMesh mesh;
  mesh.vertices = {{0, 0, 0}, {0, 0, 0.1}};
  for (const auto& [radius, height] : profile) {
    for (int i = 0; i < kSides; ++i) {
      const double angle = 2 * M_PI * i / kSides;
      mesh.vertices.emplace_back(radius * std::cos(angle), radius * std::sin(angle), height);
    }
  }
  for (int i = 0; i < kSides; ++i) {
    const int next = (i + 1) % kSides;
    mesh.triangles.push_back({0, 2 + next, 2 + i});
    mesh.triangles.push_back({1, 2 + 2 * kSides + i, 2 + 2 * kSides + next});
    for (int ring = 0; ring < 2; ++ring) {
      const int low = 2 + ring * kSides, high = low + kSides;
      mesh.triangles.push_back({low + i, low + next, high + next});
      mesh.triangles.push_back({low + i, high + next, high + i});
    }
  }
  return geometry::make_known_object("can", mesh, 0);
}

/// That turns about its axis stay open does not call for the full search, whose pose is another.
TEST(LocalizeFast, SettlesABodyOfRevolution) {
  const geometry::ObjectModel model(can());
  ASSERT_GT(model.object().symmetries.size(), 100u);
  SceneOptions options;
  options.contacts = 20;
  int settled = 0;
  for (std::uint64_t seed = 0; seed < 6; ++seed) {
    const Scene scene = make_scene(model, options, RandomStream(seed));
    const Posterior fast = localize_fast(model, scene.evidence, RandomStream(1));
    const Posterior full = localize(model, scene.evidence, RandomStream(1));
    ASSERT_EQ(fast.status, PoseStatus::certain) << seed;
    EXPECT_TRUE(within_tolerance(
        pose_error(fast.modes[0].T_frame_object, scene.truth, model.object().symmetries)))
        << seed;
    settled += fast.modes[0].T_frame_object.matrix() != full.modes[0].T_frame_object.matrix();
  }
  EXPECT_GE(settled, 4);
}

}  // namespace
}  // namespace palpate::localization
