// SPDX-License-Identifier: Apache-2.0
#include "palpate/localization/sizes.hpp"

#include <gtest/gtest.h>

#include "localization/searches.hpp"
#include "palpate/core/angle.hpp"

namespace palpate::localization {
namespace {

/// Objects that are nothing but a name and a size.
std::vector<geometry::KnownObject> objects_of(
    const std::vector<std::pair<std::string, double>>& names) {
  std::vector<geometry::KnownObject> objects;
  for (const auto& [name, size] : names) {
    objects.emplace_back();
    objects.back().name = name;
    objects.back().size = size;
    objects.back().symmetries = {Eigen::Matrix3d::Identity()};
  }
  return objects;
}

SizedCandidates pointers(const std::vector<geometry::KnownObject>& objects) {
  SizedCandidates candidates;
  for (const auto& object : objects) candidates.push_back(&object);
  return candidates;
}

Mode mode_at(double x, double angle, double weight) {
  Mode mode;
  mode.T_frame_object.translation().x() = x;
  mode.T_frame_object.linear() = exp_so3(Eigen::Vector3d(0, 0, angle));
  mode.weight = weight;
  mode.covariance = 1e-6 * Matrix6d::Identity();
  return mode;
}

Posterior posterior_of(const std::vector<Mode>& modes) {
  Posterior posterior;
  posterior.modes = modes;
  for (const Mode& mode : modes) posterior.credible_mass += mode.weight;
  posterior.seconds = 1;
  return posterior;
}

TEST(ChooseShape, SumsOverTheSizesOfAShape) {
  const auto objects = objects_of({{"mug", 0.9}, {"box", 1}, {"mug", 1.1}, {"mug", 1}});
  ObjectProbabilities found;
  found.candidates = {0.2, 0.35, 0.3, 0.1};
  found.best = 1;
  choose_shape(pointers(objects), found);
  EXPECT_EQ(found.best, 2u);  // the likeliest size of the likeliest shape
  EXPECT_NEAR(found.probability, 0.6, 1e-12);
  EXPECT_NEAR(found.size, (0.2 * 0.9 + 0.3 * 1.1 + 0.1) / 0.6, 1e-12);
}

TEST(ChooseShape, LeavesObjectsThatAreNoSizesOfOneAnother) {
  const auto objects = objects_of({{"mug", 1}, {"box", 1}, {"mug", 1}});
  ObjectProbabilities found;
  found.candidates = {0.3, 0.25, 0.4};
  found.best = 2;
  choose_shape(pointers(objects), found);  // two files may have one name
  EXPECT_EQ(found.best, 2u);
  EXPECT_EQ(found.probability, 0.4);
  EXPECT_EQ(found.size, 1);
}

TEST(ChooseShape, KeepsTheBestWhereNothingExplainsTheEvidence) {
  const auto objects = objects_of({{"mug", 0.9}, {"mug", 1}});
  ObjectProbabilities found;
  found.candidates = {0, 0};
  found.best = 1;
  choose_shape(pointers(objects), found);
  EXPECT_EQ(found.best, 1u);
  EXPECT_EQ(found.probability, 0);
  EXPECT_EQ(found.size, 1);
}

TEST(Pooled, CountsAPoseInAllSizesOnce) {
  const auto objects = objects_of({{"mug", 1}, {"mug", 1.1}, {"box", 1}});
  ObjectProbabilities found;
  found.candidates = {0.5, 0.48, 0.02};
  choose_shape(pointers(objects), found);
  const double apart = 0.004;
  const Posterior pool = pooled(pointers(objects), found,
                                {posterior_of({mode_at(0, 0, 0.5)}),
                                 posterior_of({mode_at(apart, 0.01, 0.46), mode_at(0, 3, 0.02)}),
                                 posterior_of({mode_at(0, 0, 0.02)})});
  ASSERT_EQ(pool.modes.size(), 2u);
  EXPECT_NEAR(pool.modes[0].weight, 0.96, 1e-12);
  EXPECT_NEAR(pool.modes[1].weight, 0.02, 1e-12);
  EXPECT_EQ(pool.status, PoseStatus::certain);
  EXPECT_NEAR(pool.credible_mass, 0.98, 1e-12);
  EXPECT_EQ(pool.seconds, 2);
  EXPECT_NEAR(pool.modes[0].covariance(3, 3), 1e-6 + 0.46 / 0.96 * apart * apart, 1e-12);
  EXPECT_NEAR(pool.modes[0].covariance(2, 2), 1e-6 + 0.46 / 0.96 * 1e-4, 1e-12);
}

TEST(Pooled, PosesThatDifferStayApart) {
  const auto objects = objects_of({{"mug", 1}, {"mug", 1.1}});
  ObjectProbabilities found;
  found.candidates = {0.4, 0.6};
  choose_shape(pointers(objects), found);
  const Posterior pool =
      pooled(pointers(objects), found,
             {posterior_of({mode_at(0, 0, 0.4)}), posterior_of({mode_at(0, 7 * kDegree, 0.6)})});
  ASSERT_EQ(pool.modes.size(), 2u);
  EXPECT_EQ(pool.modes[0].weight, 0.6);
  EXPECT_EQ(pool.status, PoseStatus::ambiguous);
}

TEST(Sizes, AnObjectOfAnotherSizeIsLocalizedAndMeasured) {
  SceneOptions options;
  options.contacts = 20;
  const std::vector<std::string> names = {"bracket", "bracket@0.9", "bracket@0.95", "bracket@1.05",
                                          "bracket@1.1"};
  SizedCandidates candidates;
  for (const auto& name : names) candidates.push_back(&model_of(name).object());
  for (const double size : {0.92, 1.08}) {
    const geometry::ObjectModel& touched = model_of(size < 1 ? "bracket@0.92" : "bracket@1.08");
    for (std::uint64_t seed = 0; seed < 3; ++seed) {
      const Scene scene = make_scene(touched, options, RandomStream(seed));
      Evidence evidence = scene.evidence;
      evidence.contact_area = 0.03;
      std::vector<ObjectHypothesis> hypotheses;
      for (const auto& name : names) {
        hypotheses.push_back(hypothesis_of(model_of(name), evidence, RandomStream(3), quick(), {}));
      }
      ObjectProbabilities found = object_probabilities(hypotheses, {});
      choose_shape(candidates, found);
      std::vector<Posterior> posteriors;
      for (std::size_t i = 0; i < names.size(); ++i) {
        posteriors.push_back(weighted(hypotheses[i].posterior, found.candidates[i]));
      }
      const Posterior pool = pooled(candidates, found, posteriors);
      EXPECT_NEAR(found.size, size, 0.03) << size << ' ' << seed;
      EXPECT_GT(found.probability, 0.8) << size << ' ' << seed;
      EXPECT_TRUE(within(
          pose_error(pool.modes.at(0).T_frame_object, scene.truth, touched.object().symmetries)))
          << size << ' ' << seed;
      EXPECT_GT(best_probability(pool), best_probability(posteriors[found.best]) - 1e-12);
    }
  }
}

}  // namespace
}  // namespace palpate::localization
