// SPDX-License-Identifier: Apache-2.0
#include "palpate/localization/identification.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numeric>

#include "localization/searches.hpp"
#include "palpate/core/error.hpp"

namespace palpate::localization {
namespace {

constexpr double kNever = -std::numeric_limits<double>::infinity();

Matrix6d covariance(double angle, double step) {
  Vector6d variance;
  variance << Eigen::Vector3d::Constant(angle * angle), Eigen::Vector3d::Constant(step * step);
  return variance.asDiagonal();
}

TEST(MarginalLikelihood, IsOneOfEvidenceThatIsOnlyAPrior) {
  Posterior posterior;
  posterior.modes.push_back({Eigen::Isometry3d::Identity(), 1, covariance(0.05, 0.004), {}});
  Evidence evidence;
  evidence.prior = PosePrior{{{Eigen::Isometry3d::Identity(), 1, covariance(0.06, 0.003)}}, 1e-12};
  const double log =
      log_marginal_likelihood(model_of("bracket"), evidence, posterior, 0, RandomStream(1));
  EXPECT_NEAR(log, 0, 0.05);
}

TEST(MarginalLikelihood, IsThatOfTheContactWhereItHardlyLimitsThePose) {
  // Far off the surface a contact is a false one at every pose: its likelihood is a constant.
  Posterior posterior;
  posterior.modes.push_back({Eigen::Isometry3d::Identity(), 1, covariance(0.05, 0.004), {}});
  Evidence evidence;
  evidence.prior = PosePrior{{{Eigen::Isometry3d::Identity(), 1, covariance(0.06, 0.003)}}, 1e-12};
  tactile::Contact contact;
  contact.p = {0.5, 0, 0};
  contact.n = {1, 0, 0};
  contact.point_sigma = 0.001;
  contact.normal_sigma = 0.17;
  evidence.contacts = {contact};
  const double log =
      log_marginal_likelihood(model_of("bracket"), evidence, posterior, 0, RandomStream(1));
  EXPECT_NEAR(log, 0, 0.05);  // relative to a false contact
}

TEST(MarginalLikelihood, OfNoModesIsNought) {
  EXPECT_EQ(log_marginal_likelihood(model_of("bracket"), {}, {}, 0, RandomStream(1)), kNever);
}

TEST(ObjectProbabilities, ShareTheMassWithOneThatIsNoneOfThem) {
  IdentificationOptions options;
  options.other = 0.2;
  const auto result = object_probabilities(
      {{{}, std::log(3.0), kNever}, {{}, std::log(1.0), std::log(4.0)}, {{}, kNever, kNever}},
      options);
  // 0.8 (3 + 1) / 3 for the candidates, 0.2 * 4 / 3 for another one.
  EXPECT_NEAR(result.candidates[0], 0.6, 1e-12);
  EXPECT_NEAR(result.candidates[1], 0.2, 1e-12);
  EXPECT_EQ(result.candidates[2], 0);
  EXPECT_NEAR(result.other, 0.2, 1e-12);
  EXPECT_EQ(result.best, 0u);
}

TEST(ObjectProbabilities, AreAllNoughtWhereNothingExplainsTheEvidence) {
  const auto result = object_probabilities({{{}, kNever, kNever}, {{}, kNever, kNever}}, {});
  EXPECT_EQ(result.candidates, std::vector<double>(2, 0.0));
  EXPECT_EQ(result.other, 0);
  EXPECT_THROW(object_probabilities({}, {}), BadInput);
}

TEST(ObjectProbabilities, WeighTheModesOfAPosterior) {
  Posterior posterior;
  posterior.modes.push_back({Eigen::Isometry3d::Identity(), 0.99, covariance(0.05, 0.004), {}});
  EXPECT_EQ(weighted(posterior, 0.5).status, PoseStatus::ambiguous);
  EXPECT_DOUBLE_EQ(weighted(posterior, 0.5).modes[0].weight, 0.495);
  EXPECT_EQ(weighted(posterior, 0.99).status, PoseStatus::certain);
  posterior.credible_mass = 0.99;
  EXPECT_DOUBLE_EQ(weighted(posterior, 0.5).credible_mass, 0.495);
}

ObjectProbabilities identified(const Scene& scene, const std::vector<std::string>& names) {
  Evidence evidence = scene.evidence;
  evidence.contact_area = 0.04;
  std::vector<ObjectHypothesis> hypotheses;
  for (const auto& name : names) {
    hypotheses.push_back(hypothesis_of(model_of(name), evidence, RandomStream(3), quick(), {}));
  }
  return object_probabilities(hypotheses, {});
}

TEST(Identification, FindsTheObjectAmongOthersOfAllSizes) {
  const std::vector<std::string> names = {"bracket", "box", "bunny"};
  SceneOptions options;
  options.contacts = 20;
  int right = 0;
  for (std::uint64_t seed = 0; seed < 4; ++seed) {
    for (std::size_t i = 0; i < names.size(); ++i) {
      const auto result = identified(scene_of(names[i], options, seed), names);
      right += result.best == i && result.candidates[i] > 0.9;
      EXPECT_NEAR(
          std::accumulate(result.candidates.begin(), result.candidates.end(), 0.0) + result.other,
          1, 1e-9);
    }
  }
  EXPECT_GE(right, 11);
}

TEST(Identification, OfAnObjectThatIsNoneOfThemIsNotCertain) {
  SceneOptions options;
  options.contacts = 20;
  int certain = 0;
  for (std::uint64_t seed = 0; seed < 4; ++seed) {
    const auto result = identified(scene_of("bunny", options, seed), {"box", "bracket"});
    certain += result.candidates[result.best] > 0.5;
  }
  EXPECT_EQ(certain, 0);
}

}  // namespace
}  // namespace palpate::localization
