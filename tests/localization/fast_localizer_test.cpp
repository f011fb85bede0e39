// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>
#include <vector>

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

/// A solid of revolution about z.
/// @param profile  radius and height from below, m; its ends on the axis
geometry::TriangleMesh turned(const std::vector<Eigen::Vector2d>& profile, int sides) {
  const int rings = static_cast<int>(profile.size()) - 2, top = 2 + (rings - 1) * sides;
  geometry::TriangleMesh mesh;
  mesh.vertices = {{0, 0, profile.front()[1]}, {0, 0, profile.back()[1]}};
  for (int ring = 1; ring <= rings; ++ring) {
    const Eigen::Vector2d& at = profile[static_cast<std::size_t>(ring)];
    for (int i = 0; i < sides; ++i) {
      const double angle = 2 * M_PI * i / sides;
      mesh.vertices.emplace_back(at[0] * std::cos(angle), at[0] * std::sin(angle), at[1]);
    }
  }
  for (int i = 0; i < sides; ++i) {
    const int next = (i + 1) % sides;
    mesh.triangles.push_back({0, 2 + next, 2 + i});
    mesh.triangles.push_back({1, top + i, top + next});
    for (int low = 2; low < top; low += sides) {
      const int high = low + sides;
      mesh.triangles.push_back({low + i, low + next, high + next});
      mesh.triangles.push_back({low + i, high + next, high + i});
    }
  }
  return mesh;
}

/// A can, round, with a foot that is 6 mm narrower.
geometry::KnownObject can() {
  return geometry::make_known_object(
      "can", turned({{0, 0}, {0.028, 0}, {0.034, 0.02}, {0.034, 0.1}, {0, 0.1}}, 200), 0);
}

/// With half axes of 30, 40 and 55 mm.
geometry::KnownObject ellipsoid() {
  constexpr int kRings = 24;
  std::vector<Eigen::Vector2d> profile;
  for (int k = 0; k <= kRings; ++k) {
    const double angle = M_PI * k / kRings;
    profile.emplace_back(std::sin(angle), -std::cos(angle));
  }
  geometry::TriangleMesh mesh = turned(profile, 48);
  for (auto& vertex : mesh.vertices) {
    vertex = vertex.cwiseProduct(Eigen::Vector3d(0.03, 0.04, 0.055));
  }
  return geometry::make_known_object("ellipsoid", mesh, 0);
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

/// Contacts with noise of 1 mm and 10 deg, by which the pose is 8.6 deg off. That they agree better
/// than they should does not make it more certain: 0.9999995 was stated.
TEST(LocalizeFast, StatesWhatIsWithinTheTolerance) {
  const std::pair<Eigen::Vector3d, Eigen::Vector3d> contacts[] = {
      {{-0.0535, -0.0664, -0.0035}, {0.331, -0.900, 0.284}},
      {{-0.1016, -0.0287, -0.0129}, {-0.718, 0.636, -0.282}},
      {{-0.0388, -0.0625, -0.0131}, {0.702, -0.699, 0.137}},
      {{-0.0622, -0.0022, 0.0183}, {-0.136, 0.940, 0.312}},
      {{-0.0555, -0.0468, 0.0229}, {0.294, -0.524, 0.799}},
      {{-0.0835, -0.0491, 0.0211}, {-0.293, -0.318, 0.902}},
      {{-0.0895, -0.0157, 0.0090}, {-0.668, 0.559, 0.491}},
      {{-0.0599, -0.0107, -0.0207}, {-0.084, 0.862, -0.500}},
      {{-0.0320, -0.0326, 0.0189}, {0.452, -0.501, 0.739}},
      {{-0.0835, -0.0507, -0.0470}, {-0.168, 0.236, -0.957}}};
  const geometry::ObjectModel model(ellipsoid());
  Evidence evidence;
  for (const auto& [point, normal] : contacts) {
    tactile::Contact contact;
    contact.p = point;
    contact.n = normal.normalized();
    contact.point_sigma = 0.001;
    contact.normal_sigma = 10 * kDegree;
    evidence.contacts.push_back(contact);
  }
  for (std::uint64_t seed = 0; seed < 10; ++seed) {
    const Posterior posterior = localize_fast(model, evidence, RandomStream(seed));
    EXPECT_LT(best_probability(posterior), 0.95) << seed;
    EXPECT_GT(best_probability(posterior), 0.5) << seed;
  }
}

TEST(LocalizeFast, CopiesOfAContactCountOnce) {
  SceneOptions options;
  for (const int contacts : {5, 20}) {
    options.contacts = contacts;
    const geometry::ObjectModel& model = model_of("bracket");
    const Scene scene = make_scene(model, options, RandomStream(4));
    Evidence copied = scene.evidence;
    for (int i = 0; i < 3; ++i) {
      std::ranges::copy(scene.evidence.contacts, std::back_inserter(copied.contacts));
    }
    const Posterior once = localize_fast(model, scene.evidence, RandomStream(1));
    const Posterior often = localize_fast(model, copied, RandomStream(1));
    ASSERT_FALSE(once.modes.empty());
    EXPECT_EQ(best_probability(often), best_probability(once));
    EXPECT_EQ(often.modes.at(0).T_frame_object.matrix(), once.modes[0].T_frame_object.matrix());
  }
}

}  // namespace
}  // namespace palpate::localization
