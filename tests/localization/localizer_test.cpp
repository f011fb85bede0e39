// SPDX-License-Identifier: Apache-2.0
#include "palpate/localization/localizer.hpp"

#include <gtest/gtest.h>

#include "localization/searches.hpp"
#include "palpate/core/angle.hpp"

namespace palpate::localization {
namespace {

double success_rate(const std::string& name, const SceneOptions& options, int scenes) {
  const geometry::ObjectModel& model = model_of(name);
  int successes = 0;
  for (int i = 0; i < scenes; ++i) {
    const Scene scene = scene_of(name, options, static_cast<std::uint64_t>(i));
    successes += right(localize(model, scene.evidence, RandomStream(7), quick()), model, scene);
  }
  return successes / static_cast<double>(scenes);
}

TEST(Localize, ExactContactsGiveTheExactPose) {
  SceneOptions options;
  options.contacts = 20;
  options.point_noise = 0;
  options.normal_noise = 0;
  for (const std::uint64_t seed : {1U, 2U, 3U}) {
    const geometry::ObjectModel& model = model_of("bunny");
    Scene scene = scene_of("bunny", options, seed);
    scene.evidence.noise_scale_prior = 0;
    const Posterior posterior = localize(model, scene.evidence, RandomStream(seed));
    ASSERT_FALSE(posterior.modes.empty());
    EXPECT_EQ(posterior.status, PoseStatus::certain);
    const PoseError error = mode_error(posterior.modes[0], scene.truth, model.object().symmetries);
    EXPECT_LT(error.rotation, 1 * kDegree);
    EXPECT_LT(error.translation, 0.001);
  }
}

TEST(Localize, SucceedsOftenOnNoisyContacts) {
  for (const std::string name : {"box", "bracket", "bunny"}) {
    SceneOptions options;
    options.contacts = 20;
    EXPECT_GE(success_rate(name, options, 15), 0.8) << name;
    options.contacts = 10;
    EXPECT_GE(success_rate(name, options, 15), 0.65) << name;
  }
}

TEST(Localize, PointsWithoutNormalsSufficeWhereThereAreMany) {
  const geometry::ObjectModel& model = model_of("bracket");
  SceneOptions options;
  options.contacts = 30;
  int successes = 0;
  for (std::uint64_t seed = 0; seed < 10; ++seed) {
    Scene scene = scene_of("bracket", options, seed);
    for (auto& contact : scene.evidence.contacts) contact.n.setZero();
    successes += right(localize(model, scene.evidence, RandomStream(7), quick()), model, scene);
  }
  EXPECT_GE(successes, 7);
}

/// Each touch is sensed by a pad of which any of three points may be the one that touches.
TEST(Localize, FindsWhichCandidatesTouch) {
  const geometry::ObjectModel& model = model_of("bracket");
  SceneOptions options;
  options.contacts = 20;
  int successes = 0;
  for (std::uint64_t seed = 0; seed < 10; ++seed) {
    Scene scene = scene_of("bracket", options, seed);
    RandomStream random(seed, "candidates");
    std::vector<tactile::Contact> candidates;
    for (tactile::Contact contact : scene.evidence.contacts) {
      contact.group = static_cast<int>(candidates.size());
      const Eigen::Vector3d touching = contact.p;
      for (const double step : {0.0, 0.006, 0.012}) {
        contact.p = touching + step * random.unit_vector();
        candidates.push_back(contact);
      }
    }
    scene.evidence.contacts = candidates;
    successes += right(localize(model, scene.evidence, RandomStream(7), quick()), model, scene);
  }
  EXPECT_GE(successes, 7);
}

TEST(Localize, AGroupOfOneIsAContact) {
  const geometry::ObjectModel& model = model_of("bracket");
  SceneOptions options;
  options.contacts = 14;
  Scene scene = scene_of("bracket", options, 3);
  for (std::size_t k = 0; k < scene.evidence.contacts.size(); ++k) {
    scene.evidence.contacts[k].group = static_cast<int>(k);
  }
  Evidence alone = scene.evidence;
  for (auto& contact : alone.contacts) contact.group = -1;
  for (const std::uint64_t seed : {0U, 1U, 2U, 3U}) {
    const Posterior grouped = localize(model, scene.evidence, RandomStream(seed), quick());
    const Posterior expected = localize(model, alone, RandomStream(seed), quick());
    EXPECT_NEAR(best_probability(grouped), best_probability(expected), 0.1) << seed;
  }
}

TEST(Localize, FourContactsSufficeOnATable) {
  SceneOptions options;
  options.contacts = 4;
  options.table = true;
  for (const std::string name : {"box", "bracket", "bunny"}) {
    EXPECT_GE(success_rate(name, options, 15), 0.7) << name;
  }
}

TEST(Localize, BearsFalseContacts) {
  SceneOptions options;
  options.contacts = 20;
  options.false_share = 0.15;
  EXPECT_GE(success_rate("bunny", options, 12), 0.75);
}

TEST(Localize, CountsEqualPosesOfASymmetricObjectOnce) {
  const geometry::ObjectModel& model = model_of("box");
  ASSERT_EQ(model.object().symmetries.size(), 4U);
  SceneOptions options;
  options.contacts = 20;
  options.table = true;
  const Scene scene = scene_of("box", options, 4);
  const Posterior posterior = localize(model, scene.evidence, RandomStream(1));
  ASSERT_FALSE(posterior.modes.empty());
  EXPECT_EQ(posterior.status, PoseStatus::certain);
  EXPECT_GT(posterior.modes[0].weight, 0.95);
}

TEST(Localize, WeightsAreAsOftenRight) {
  double expected = 0, successes = 0;
  constexpr int kScenes = 60;
  const std::string names[] = {"mug", "bottle", "box", "bracket", "bunny"};
  for (std::uint64_t i = 0; i < kScenes; ++i) {
    SceneOptions options;
    options.contacts = 4 + static_cast<int>(i % 4);
    const std::string& name = names[i % 5];
    const geometry::ObjectModel& model = model_of(name);
    const Scene scene = scene_of(name, options, i);
    const Posterior posterior = localize(model, scene.evidence, RandomStream(i), quick());
    expected += posterior.modes.empty() ? 0 : posterior.modes[0].weight;
    successes += right(posterior, model, scene);
  }
  EXPECT_NEAR(expected / kScenes, successes / kScenes, 0.2);
}

/// Success with `change` made to what the search is given.
template <class Change>
double success_when(const std::string& name, const Change& change) {
  const geometry::ObjectModel& model = model_of(name);
  constexpr int kScenes = 15;
  int successes = 0;
  for (int i = 0; i < kScenes; ++i) {
    Scene scene = scene_of(name, {}, static_cast<std::uint64_t>(i));
    change(scene.evidence);
    successes += right(localize(model, scene.evidence, RandomStream(7), quick()), model, scene);
  }
  return successes / static_cast<double>(kScenes);
}

TEST(Localize, BearsNoiseOfAnotherSizeThanStated) {
  const double exact = success_when("bottle", [](Evidence&) {});
  for (const double times : {0.5, 2.0}) {
    const double wrong = success_when("bottle", [times](Evidence& evidence) {
      for (auto& contact : evidence.contacts) {
        contact.point_sigma *= times;
        contact.normal_sigma *= times;
      }
    });
    EXPECT_GE(wrong, exact - 0.1) << times;
  }
}

TEST(Localize, TenThousandContactsGiveThePose) {
  const geometry::ObjectModel& model = model_of("bunny");
  SceneOptions options;
  options.contacts = 100;
  Scene scene = scene_of("bunny", options, 5);
  auto& contacts = scene.evidence.contacts;
  while (contacts.size() < 10000) contacts.push_back(contacts[contacts.size() - 100]);
  const Posterior posterior = localize(model, scene.evidence, RandomStream(1), quick());
  EXPECT_TRUE(right(posterior, model, scene));
}

TEST(Localize, ATableAloneGivesThePrior) {
  const geometry::ObjectModel& model = model_of("bracket");
  Evidence evidence;
  evidence.table.emplace().T_frame_table = Eigen::Isometry3d::Identity();
  evidence.table->half_width = 0.002;
  evidence.table->edge_sigma = 0.001;
  const Posterior posterior = localize(model, evidence, RandomStream(1));
  EXPECT_EQ(posterior.status, PoseStatus::ambiguous);
  ASSERT_FALSE(posterior.modes.empty());
  ASSERT_TRUE(posterior.modes[0].free_axis);
  EXPECT_NEAR(posterior.modes[0].free_axis->extent, M_PI, 1e-9);
  EXPECT_NEAR(posterior.modes[0].weight, model.object().stable_poses[0].probability, 0.1);
}

TEST(Localize, IsTheSameForTheSameSeed) {
  const Scene scene = scene_of("bracket", {}, 1);
  const auto run = [&] {
    return localize(model_of("bracket"), scene.evidence, RandomStream(3), quick());
  };
  const Posterior a = run(), b = run();
  ASSERT_EQ(a.modes.size(), b.modes.size());
  for (std::size_t i = 0; i < a.modes.size(); ++i) {
    EXPECT_EQ(a.modes[i].weight, b.modes[i].weight);
    EXPECT_EQ(a.modes[i].T_frame_object.matrix(), b.modes[i].T_frame_object.matrix());
    EXPECT_EQ(a.modes[i].covariance, b.modes[i].covariance);
  }
}

TEST(Localize, MovesWithTheFrame) {
  SceneOptions options;
  options.contacts = 12;
  Scene scene = scene_of("bunny", options, 5);
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.linear() = exp_so3({0.3, -1, 2});
  T.translation() << 1, -2, 0.5;
  scene.truth = T * scene.truth;
  for (auto& contact : scene.evidence.contacts) {
    contact.p = T * contact.p;
    contact.n = T.linear() * contact.n;
  }
  const geometry::ObjectModel& model = model_of("bunny");
  EXPECT_TRUE(right(localize(model, scene.evidence, RandomStream(1)), model, scene));
}

TEST(ObjectModel, SamplesTheWholeSurface) {
  const geometry::ObjectModel& model = model_of("box");
  EXPECT_NEAR(model.area(), geometry::area(model.object().mesh), 1e-12);
  Eigen::AlignedBox3d box;
  Eigen::Vector3f flux = Eigen::Vector3f::Zero();
  for (const auto& point : model.surface()) {
    box.extend(point.p.cast<double>());
    flux += point.n;
    EXPECT_LT(std::abs(model.field().distance(point.p)), 0.001F);
  }
  EXPECT_LT((box.sizes() - geometry::bounds(model.object().mesh).sizes()).norm(), 0.004);
  EXPECT_LT(flux.norm() / static_cast<float>(model.surface().size()), 0.02F);
}

}  // namespace
}  // namespace palpate::localization
