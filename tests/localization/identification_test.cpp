// SPDX-License-Identifier: Apache-2.0
#include "palpate/localization/identification.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numeric>

#include "localization/searches.hpp"
#include "palpate/core/error.hpp"
#include "palpate/geometry/mesh/sampling.hpp"

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
      log_marginal_likelihood(model_of("bracket"), evidence, posterior, RandomStream(1));
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
      log_marginal_likelihood(model_of("bracket"), evidence, posterior, RandomStream(1));
  EXPECT_NEAR(log, 0, 0.05);  // relative to a false contact
}

TEST(MarginalLikelihood, OfNoModesIsNought) {
  EXPECT_EQ(log_marginal_likelihood(model_of("bracket"), {}, {}, RandomStream(1)), kNever);
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

geometry::ObjectModel box_larger_by(double more) {
  const Eigen::Vector3d half = (Eigen::Vector3d(0.06, 0.05, 0.08).array() + more) / 2;
  geometry::TriangleMesh mesh;
  for (int i = 0; i < 8; ++i) {
    const Eigen::Vector3d signs(i & 4 ? 1 : -1, i & 2 ? 1 : -1, i & 1 ? 1 : -1);
    mesh.vertices.push_back(signs.cwiseProduct(half));
  }
  mesh.triangles = {{0, 1, 3}, {0, 3, 2}, {4, 6, 7}, {4, 7, 5}, {0, 4, 5}, {0, 5, 1},
                    {2, 3, 7}, {2, 7, 6}, {0, 2, 6}, {0, 6, 4}, {1, 5, 7}, {1, 7, 3}};
  return geometry::ObjectModel(geometry::make_known_object("box", mesh, 0.1));
}

/// Noisy contacts all over the object.
Evidence touched_all_over(const geometry::ObjectModel& object, int count, std::uint64_t seed) {
  RandomStream random(seed, "touched");
  Evidence evidence;
  for (const auto& sample : geometry::sample_surface(object.object().mesh, count, random)) {
    tactile::Contact contact;
    contact.p = sample.point;
    contact.n = sample.normal;
    disturb(contact, {}, random);
    evidence.contacts.push_back(contact);
  }
  evidence.contact_area = 0.024;
  return evidence;
}

double other_than_the_box(const geometry::ObjectModel& touched, int count, std::uint64_t seed) {
  static const geometry::ObjectModel box = box_larger_by(0);
  const Evidence evidence = touched_all_over(touched, count, seed);
  return object_probabilities({hypothesis_of(box, evidence, RandomStream(seed), {}, {})}, {}).other;
}

TEST(Identification, OfAnObjectSomeMillimetresLargerThanTheCandidateNamesAnother) {
  for (const double more : {0.008, 0.012}) {
    const geometry::ObjectModel larger = box_larger_by(more);
    for (const int count : {12, 16, 20}) {
      for (std::uint64_t seed = 1; seed <= 2; ++seed) {
        EXPECT_GT(other_than_the_box(larger, count, seed), 0.9) << more << ", " << count;
      }
    }
  }
}

TEST(Identification, OfTheCandidateItselfNamesNoOther) {
  const geometry::ObjectModel same = box_larger_by(0);
  for (const int count : {8, 12, 20}) {
    for (std::uint64_t seed = 1; seed <= 2; ++seed) {
      EXPECT_LT(other_than_the_box(same, count, seed), 0.05) << count;
    }
  }
}

/// What was known before is of the candidate's surface, too.
TEST(Identification, APoseThatWasKnownHoldsAnotherObjectLessExactly) {
  const geometry::ObjectModel box = box_larger_by(0);
  Evidence evidence = touched_all_over(box_larger_by(0.012), 12, 3);
  evidence.prior = PosePrior{
      {{Eigen::Isometry3d(Eigen::Translation3d(0.006, 0.006, 0.006)), 1, covariance(0.01, 0.001)}},
      1e-9};
  const auto hypothesis = hypothesis_of(box, evidence, RandomStream(3), {}, {});
  EXPECT_GT(hypothesis.log_evidence_other, hypothesis.log_evidence + 3);
}

}  // namespace
}  // namespace palpate::localization
