// SPDX-License-Identifier: Apache-2.0
#include "localization/tracking/contact_memory.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "localization/scenes.hpp"
#include "palpate/core/random.hpp"

namespace palpate::localization {
namespace {

tactile::Contact contact_at(int finger, const Eigen::Vector3d& p, const Eigen::Vector3d& n) {
  tactile::Contact contact;
  contact.finger = finger;
  contact.p = p;
  contact.n = n;
  return contact;
}

TEST(MeanContacts, KeepNoNormalWhereThereIsNone) {
  const Eigen::Vector3d none = Eigen::Vector3d::Zero();
  const ContactFrames frames = {{contact_at(1, {0.01, 0, 0}, none)},
                                {contact_at(1, {0.03, 0, 0}, none)}};
  const auto means = mean_contacts(frames, {});
  ASSERT_EQ(means.size(), 1U);
  EXPECT_NEAR(means[0].p.x(), 0.02, 1e-12);
  EXPECT_FALSE(means[0].has_normal());
  const KnownErrors errors = mean_errors(frames, model_of("box"), Eigen::Isometry3d::Identity());
  EXPECT_FALSE(mean_contacts(frames, {}, errors)[0].has_normal());
}

TEST(VarianceOfMean, IsThatOfWhiteOrOfLastingErrorsAtTheEnds) {
  EXPECT_NEAR(variance_of_mean(1, {}), 1, 1e-12);
  EXPECT_NEAR(variance_of_mean(20, {0, 0.5, 0.01}), 1.0 / 20, 1e-12);
  EXPECT_NEAR(variance_of_mean(20, {1, 1e6, 0.01}), 1, 1e-6);
}

TEST(VarianceOfMean, AgreesWithDrawnErrorsAsTheCovarianceDoes) {
  const LastingErrors errors{0.5, 0.2, 0.01};
  constexpr int kRuns = 20000;
  constexpr std::size_t kBefore = 10, kAfter = 15;
  const double keep = std::exp(-errors.frame / errors.time);
  RandomStream random(1);
  double variance = 0, covariance = 0;
  for (int run = 0; run < kRuns; ++run) {
    double lasting = random.normal(), before = 0, after = 0;
    for (std::size_t k = 0; k < kBefore + kAfter; ++k) {
      const double error =
          std::sqrt(errors.share) * lasting + std::sqrt(1 - errors.share) * random.normal();
      (k < kBefore ? before : after) += error / (k < kBefore ? kBefore : kAfter);
      lasting = keep * lasting + std::sqrt(1 - keep * keep) * random.normal();
    }
    variance += after * after / kRuns;
    covariance += before * after / kRuns;
  }
  // A product of two such errors has a standard error of about 1 % over 20000 runs.
  EXPECT_NEAR(variance_of_mean(kAfter, errors), variance, 0.04 * variance);
  EXPECT_NEAR(covariance_of_means(kBefore, kAfter, errors), covariance, 0.06 * covariance);
}

TEST(MeanContacts, HasFiniteErrorsWhereAllErrorsLastAndFramesCoincide) {
  const ContactFrames frames(5, {contact_at(-1, {0, 0, 0.1}, Eigen::Vector3d::UnitZ())});
  const KnownErrors known{frames.back(), {5}};
  for (const double spacing : {0.0, 1e-12, 1e-3}) {
    const auto means = mean_contacts(frames, {1, 0.5, spacing}, known);
    EXPECT_GT(means[0].point_sigma, 0);
    EXPECT_TRUE(std::isfinite(means[0].normal_sigma));
  }
}

TEST(MeanContacts, AveragesEachFingerThatStillTouches) {
  const Eigen::Vector3d z = Eigen::Vector3d::UnitZ();
  const ContactFrames frames = {{contact_at(1, {0, 0, 0.001}, z), contact_at(2, {0.1, 0, 0}, z)},
                                {contact_at(1, {0, 0, -0.001}, z)},
                                {contact_at(3, {0, 0.1, 0}, z), contact_at(1, {0, 0, 0.003}, z)}};
  const auto means = mean_contacts(frames, {0, 0.5, 0.01});
  ASSERT_EQ(means.size(), 2u);
  EXPECT_EQ(means[0].finger, 3);
  EXPECT_NEAR(means[0].point_sigma, 0.001, 1e-12);
  EXPECT_NEAR(means[1].p.z(), 0.001, 1e-12);
  EXPECT_NEAR(means[1].point_sigma, 0.001 / std::sqrt(3.0), 1e-9);
  EXPECT_TRUE(mean_contacts({}, {}).empty());
}

TEST(MeanContacts, TakesOffTheErrorsThatAreKnownAsFarAsTheyKeep) {
  const geometry::ObjectModel& box = model_of("box");
  const double top = static_cast<double>(box.bounds().max().z());
  const Eigen::Vector3d tilted = Eigen::Vector3d(0.1, 0, 1).normalized();
  const ContactFrames frames(10, {contact_at(-1, {0, 0, top + 0.001}, tilted)});
  const auto known = mean_errors(frames, box, Eigen::Isometry3d::Identity());
  ASSERT_EQ(known.mean.size(), 1u);
  EXPECT_NEAR(known.mean[0].p.z(), 0.001, 1e-4);
  EXPECT_NEAR(known.mean[0].n.x(), tilted.x(), 0.01);
  const auto lasting = mean_contacts(frames, {1, 1e6, 0.01}, known);
  EXPECT_NEAR(lasting[0].p.z(), top, 1e-4);
  EXPECT_LT(lasting[0].point_sigma, 1e-4);
  const auto white = mean_contacts(frames, {0, 0.5, 0.01}, known);
  EXPECT_NEAR(white[0].p.z(), top + 0.001, 1e-12);
}

}  // namespace
}  // namespace palpate::localization
