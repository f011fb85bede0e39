// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <limits>

#include "localization/searches.hpp"
#include "palpate/core/error.hpp"
#include "palpate/localization/localizer.hpp"

namespace palpate::localization {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

TEST(Localize, SaysWhenTheContactsAreOfSomethingElse) {
  const geometry::ObjectModel& model = model_of("bracket");
  SceneOptions options;
  options.contacts = 20;
  for (const std::uint64_t seed : {1U, 2U, 3U, 4U}) {
    Scene scene = scene_of("mug", options, seed);
    scene.evidence.contacts[0].finger = 1;
    EXPECT_EQ(localize(model, scene.evidence, RandomStream(1), quick()).status,
              PoseStatus::no_pose);
  }
}

/// The misfit that is allowed grows with the expected share of false contacts, not without end.
TEST(Localize, DistinguishesFalseContactsFromAnotherObject) {
  SceneOptions options;
  options.contacts = 20;
  for (const double share : {0.1, 0.2, 0.3}) {
    for (const std::uint64_t seed : {1U, 2U, 3U, 4U}) {
      Scene scene = scene_of("mug", options, seed);
      scene.evidence.false_contact_share = share;
      EXPECT_EQ(localize(model_of("bracket"), scene.evidence, RandomStream(1), quick()).status,
                PoseStatus::no_pose)
          << share;
      SceneOptions some_false = options;
      some_false.false_share = share;
      const Scene own = scene_of("bracket", some_false, seed);
      EXPECT_NE(localize(model_of("bracket"), own.evidence, RandomStream(1), quick()).status,
                PoseStatus::no_pose)
          << share;
    }
  }
}

TEST(Localize, RefusesContactsInMillimetres) {
  Scene scene = scene_of("box", {}, 1);
  for (auto& contact : scene.evidence.contacts) contact.p *= 1000;
  EXPECT_THROW(localize(model_of("box"), scene.evidence, RandomStream(1)), BadInput);
}

TEST(Localize, FlippedNormalsGiveNoPose) {
  SceneOptions options;
  options.contacts = 20;
  Scene scene = scene_of("bunny", options, 1);
  for (auto& contact : scene.evidence.contacts) contact.n *= -1;
  EXPECT_EQ(localize(model_of("bunny"), scene.evidence, RandomStream(1)).status,
            PoseStatus::no_pose);
}

TEST(Localize, NoContactsGiveNoPose) {
  const Posterior posterior = localize(model_of("box"), {}, RandomStream(1));
  EXPECT_EQ(posterior.status, PoseStatus::no_pose);
  EXPECT_TRUE(posterior.modes.empty());
}

TEST(Localize, ContactsAtOnePointAreAmbiguous) {
  Scene scene = scene_of("bunny", {}, 3);
  scene.evidence.contacts.assign(8, scene.evidence.contacts.front());
  const Posterior posterior = localize(model_of("bunny"), scene.evidence, RandomStream(1), quick());
  EXPECT_EQ(posterior.status, PoseStatus::ambiguous);
  EXPECT_LT(posterior.modes.at(0).weight, 0.5);
}

TEST(Localize, ContactsOnOnePlaneAreAmbiguous) {
  const geometry::ObjectModel& model = model_of("box");
  Evidence evidence;
  for (int k = 0; k < 9; ++k) {
    tactile::Contact contact;
    contact.p = {0.008 * (k % 3), 0.008 * static_cast<double>(k / 3), 0};
    contact.n = Eigen::Vector3d::UnitZ();
    evidence.contacts.push_back(contact);
  }
  const Posterior posterior = localize(model, evidence, RandomStream(1), quick());
  EXPECT_EQ(posterior.status, PoseStatus::ambiguous);
  for (const Mode& mode : posterior.modes) {  // the plane itself is found
    const double height = std::abs(mode.T_frame_object.translation().z());
    EXPECT_TRUE(std::abs(height - 0.025) < 0.004 || std::abs(height - 0.047) < 0.004 ||
                std::abs(height - 0.0875) < 0.004)
        << height;
  }
}

TEST(Localize, OneContactIsAmbiguous) {
  SceneOptions options;
  options.contacts = 1;
  const Scene scene = scene_of("bracket", options, 1);
  const Posterior posterior = localize(model_of("bracket"), scene.evidence, RandomStream(1));
  EXPECT_EQ(posterior.status, PoseStatus::ambiguous);
  ASSERT_FALSE(posterior.modes.empty());
  EXPECT_LT(posterior.modes[0].weight, 0.5);
}

template <class Spoil>
void expect_bad(const std::string& value, Spoil&& spoil) {
  SceneOptions options;
  options.table = true;
  Scene scene = scene_of("box", options, 1);
  scene.evidence.free_space.push_back({Eigen::Vector3d::Zero(), 0.01});
  spoil(scene.evidence);
  try {
    localize(model_of("box"), scene.evidence, RandomStream(1), quick());
    FAIL() << "accepted; expected a complaint about " << value;
  } catch (const BadInput& error) {
    EXPECT_NE(std::string(error.what()).find(value), std::string::npos) << error.what();
  }
}

TEST(Localize, RefusesWhatCannotBeUsed) {
  expect_bad("nan", [](Evidence& e) { e.contacts[2].p.x() = kNan; });
  expect_bad("contact 2", [](Evidence& e) { e.contacts[2].n.x() = kNan; });
  expect_bad("length 2", [](Evidence& e) { e.contacts[0].n *= 2; });
  expect_bad("point_sigma is 0", [](Evidence& e) { e.contacts[0].point_sigma = 0; });
  expect_bad("normal_sigma is -1", [](Evidence& e) { e.contacts[0].normal_sigma = -1; });
  expect_bad("false_contact_share is 1", [](Evidence& e) { e.false_contact_share = 1; });
  expect_bad("noise_scale_prior is 1", [](Evidence& e) { e.noise_scale_prior = 1; });
  expect_bad("size_prior is -0.1", [](Evidence& e) { e.size_prior = -0.1; });
  expect_bad("offset 0: sigma is 0", [](Evidence& e) { e.offsets = {{0.0, {}}}; });
  expect_bad("contact 1000 of", [](Evidence& e) { e.offsets = {{0.001, {{1000}}}}; });
  expect_bad("contact 0 is in another one", [](Evidence& e) {
    e.offsets = {{0.001, {{0}}}, {0.001, {{0}}}};
  });
  expect_bad("offset 0: its rotation is off", [](Evidence& e) {
    e.offsets = {{0.001, {{0, 2 * Eigen::Matrix3d::Identity()}}}};
  });
  expect_bad("penetration_sigma is 0", [](Evidence& e) { e.penetration_sigma = 0; });
  expect_bad("radius is -0.5", [](Evidence& e) { e.free_space[0].radius = -0.5; });
  expect_bad("free sphere 0", [](Evidence& e) { e.free_space[0].center.y() = kNan; });
  expect_bad("free sphere 0: a coordinate", [](Evidence& e) { e.free_space[0].center.y() = 1e20; });
  expect_bad("free sphere 0: its radius", [](Evidence& e) { e.free_space[0].radius = 1e20; });
  expect_bad("contact 0: a coordinate", [](Evidence& e) { e.contacts[0].p.x() = -1e200; });
  expect_bad("surface_sigma", [](Evidence& e) { e.surface_sigma = 1e300; });
  expect_bad("tilt_sigma is 0", [](Evidence& e) { e.table->tilt_sigma = 0; });
  expect_bad("1 stable pose weights", [](Evidence& e) { e.table->stable_pose_weights = {1}; });
  expect_bad("T_frame_table", [](Evidence& e) { e.table->T_frame_table(0, 3) = kNan; });
}

TEST(ObjectModel, RefusesAnObjectWithoutTriangles) {
  EXPECT_THROW(geometry::ObjectModel{geometry::KnownObject{}}, BadInput);
}

}  // namespace
}  // namespace palpate::localization
