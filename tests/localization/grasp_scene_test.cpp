// SPDX-License-Identifier: Apache-2.0
#include "palpate/localization/synthetic/grasp_scene.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "localization/scenes.hpp"
#include "palpate/hand/shadow.hpp"

namespace palpate::localization {
namespace {

/// A palm of three balls and five fingers of one hinge and two balls each.
hand::Description toy_hand() {
  hand::Description hand = hand::shadow_hand();
  hand.palm = 0;
  hand.links.push_back({"palm", -1, Eigen::Isometry3d::Identity(), {0, 0, 0}, -1});
  for (const double z : {0.02, 0.05, 0.08}) hand.spheres.push_back({0, {0, 0, z}, 0.01});
  const hand::PerFinger<const char*> joints{"THJ2", "FFJ3", "MFJ3", "RFJ3", "LFJ3"};
  for (int f = 0; f < hand::kShadowFingers; ++f) {
    hand::Link link{joints[static_cast<std::size_t>(f)], 0, Eigen::Isometry3d::Identity(),
                    Eigen::Vector3d(1, 0, 0), -1};
    link.joint = hand::shadow_hand().joint(link.name);
    link.T_parent_link.translation() =
        f == 0 ? Eigen::Vector3d(0.04, -0.02, 0.02) : Eigen::Vector3d(0.05 - 0.022 * f, 0, 0.09);
    hand.fingers[static_cast<std::size_t>(f)].link = static_cast<int>(hand.links.size());
    for (const double z : {0.03, 0.06}) {
      hand.spheres.push_back({static_cast<int>(hand.links.size()), {0, 0, z}, 0.0075});
    }
    hand.links.push_back(link);
  }
  return hand;
}

GraspScene scene_with(const std::string& name, const GraspSceneOptions& options,
                      std::uint64_t seed) {
  const geometry::ObjectModel& model = model_of(name);
  return make_grasp_scene(model, mesh_of(model), toy_hand(), options, RandomStream(seed));
}

TEST(GraspScene, ContactsAreOnTheSurfaceAndTheHandIsOutside) {
  for (const bool table : {false, true}) {
    GraspSceneOptions options;
    options.table = table;
    options.contacts = 8;
    const GraspScene scene = scene_with("bunny", options, 1);
    const auto& mesh = mesh_of(model_of("bunny"));
    EXPECT_GE(scene.contacts(), 8);
    for (const auto& grasp : scene.grasps) {
      for (const auto& contact : grasp.contacts) {
        EXPECT_NEAR(mesh.signed_distance(scene.truth.inverse() * contact.p), 0, 1e-6);
        EXPECT_NEAR(contact.n.norm(), 1, 1e-9);
        EXPECT_GT(mesh.signed_distance(scene.truth.inverse() * (contact.p + 0.002 * contact.n)), 0);
      }
      for (const auto& ball : grasp.hand) {
        EXPECT_GT(mesh.signed_distance(scene.truth.inverse() * ball.center), ball.radius - 0.001);
        const double floor = table ? ball.radius - 0.001 : -1;
        EXPECT_GT(ball.center.z(), floor);
      }
    }
  }
}

TEST(GraspScene, FalseContactsAreAsCommonAsAsked) {
  GraspSceneOptions options;
  options.false_share = 0.3;
  int count = 0, lies = 0;
  for (std::uint64_t seed = 0; seed < 8; ++seed) {
    for (const auto& grasp : scene_with("box", options, seed).grasps) {
      count += static_cast<int>(grasp.is_false.size());
      lies += static_cast<int>(std::count(grasp.is_false.begin(), grasp.is_false.end(), true));
    }
  }
  EXPECT_GT(lies, 0.15 * count);  // fingers that meet the object first do not lie
  EXPECT_LT(lies, 0.6 * count);
}

TEST(SceneEvidence, ReturnsWhatIsAskedFor) {
  const GraspScene scene = scene_with("box", {}, 2);
  SceneEvidenceOptions options;
  options.contacts = 5;
  options.assumed_noise = 2;
  options.swept = false;
  const Evidence evidence = scene_evidence(scene, options, RandomStream(1));
  EXPECT_EQ(evidence.contacts.size(), 5U);
  EXPECT_DOUBLE_EQ(evidence.contacts[0].point_sigma, 0.002);
  EXPECT_EQ(evidence.free_space.size() % toy_hand().spheres.size(), 0U);
  EXPECT_FALSE(evidence.table);
  EXPECT_TRUE(evidence.offsets.empty());
  options.assumed_offset = 0.003;
  const Evidence displaced = scene_evidence(scene, options, RandomStream(1));
  std::size_t shared = 0;
  for (const auto& offset : displaced.offsets) {
    EXPECT_DOUBLE_EQ(offset.sigma, 0.003 / std::sqrt(3.0));
    shared += offset.members.size();
  }
  EXPECT_EQ(shared, displaced.contacts.size());
  options.hand = false;
  EXPECT_TRUE(scene_evidence(scene, options, RandomStream(1)).free_space.empty());
}

}  // namespace
}  // namespace palpate::localization
