// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "localization/searches.hpp"
#include "palpate/localization/pose_prior.hpp"

namespace palpate::localization {
namespace {

Scene bracket_scene(int contacts) {
  SceneOptions options;
  options.contacts = contacts;
  return scene_of("bracket", options, 3);
}

Posterior searched(const Evidence& evidence) {
  return localize(model_of("bracket"), evidence, RandomStream(7), quick());
}

TEST(PriorFrom, OfACertainPoseIsNotOverruledByContactsThatAgree) {
  const Scene scene = bracket_scene(20);
  const Posterior before = searched(scene.evidence);
  ASSERT_EQ(before.status, PoseStatus::certain);
  for (const std::size_t contacts : {1U, 2U, 3U}) {
    Evidence few = scene.evidence;
    few.contacts.resize(contacts);
    few.prior = prior_from(before, Matrix6d::Zero());
    const Posterior after = searched(few);
    EXPECT_EQ(after.status, PoseStatus::certain) << contacts;
    ASSERT_FALSE(after.modes.empty());
    EXPECT_TRUE(right(after, model_of("bracket"), scene)) << contacts;
  }
}

TEST(PriorFrom, IsOverruledByManyContactsElsewhere) {
  const Scene scene = bracket_scene(20);
  Posterior elsewhere = searched(scene.evidence);
  for (Mode& mode : elsewhere.modes) mode.T_frame_object.pretranslate(Eigen::Vector3d(0.03, 0, 0));
  elsewhere.residual_set.clear();
  Evidence evidence = scene.evidence;
  evidence.prior = prior_from(elsewhere, Matrix6d::Zero());
  EXPECT_TRUE(right(searched(evidence), model_of("bracket"), scene));
}

TEST(PriorFrom, KeepsTheMassThatIsInNoMode) {
  const Scene scene = bracket_scene(3);
  const Posterior before = searched(scene.evidence);
  ASSERT_GT(before.residual_mass(), 0.5);
  ASSERT_FALSE(before.residual_set.empty());
  const PosePrior prior = prior_from(before, Matrix6d::Zero());
  double total = 0;
  for (const auto& component : prior.components) total += component.weight;
  EXPECT_NEAR(total, before.credible_mass, 1e-9);
  Evidence nothing_new;
  nothing_new.prior = prior;
  const Posterior after = searched(nothing_new);
  EXPECT_GT(after.residual_mass(), before.residual_mass() - 0.15);
  EXPECT_LE(after.credible_mass, before.credible_mass + 1e-9);
}

}  // namespace
}  // namespace palpate::localization
