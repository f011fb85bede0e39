// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

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

}  // namespace
}  // namespace palpate::localization
