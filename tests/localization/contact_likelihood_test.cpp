// SPDX-License-Identifier: Apache-2.0
#include "localization/likelihood/contact_likelihood.hpp"

#include <gtest/gtest.h>

#include "localization/scenes.hpp"
#include "palpate/core/random.hpp"

namespace palpate::localization {
namespace {

NoiseLevels noise_of(const std::vector<Hypothesis>& levels) {
  tactile::Contact contact;
  contact.p = Eigen::Vector3d::Zero();
  contact.n = Eigen::Vector3d::UnitX();
  return make_noise(model_of("box"), {}, contact, levels, 1);
}

/// The same by the formula of ContactTerm, with Eigen's exponential.
NoiseArray expected(const NoiseLevels& noise, const NoiseArray& growth, const ContactPlace& place) {
  const NoiseArray distance = place.distance + growth * place.scale_derivative;
  const NoiseArray wider = 1 + noise.curvature_widening * place.squared_curvature;
  const NoiseArray q = place.normal * noise.normal_precision / wider;
  const NoiseArray normal = (1 - noise.outlier_share) * (-q).exp() +
                            noise.outlier_share / kOutlierVariance * (-q / kOutlierVariance).exp();
  return (1 +
          noise.odds / wider * normal * (-distance.square() * noise.half_point_precision).exp()) *
         noise.inverse_peak;
}

TEST(ContactLikelihood, HasTheBitsOfTheFormula) {
  const std::vector<Hypothesis> levels = hypotheses({});
  ASSERT_EQ(levels.size(), static_cast<std::size_t>(kMaxNoiseHypotheses));
  NoiseArray growth(kMaxNoiseHypotheses);
  for (Eigen::Index j = 0; j < growth.size(); ++j) {
    growth[j] = static_cast<float>(levels[static_cast<std::size_t>(j)].growth);
  }
  const NoiseLevels alike = noise_of(levels);
  EXPECT_TRUE(alike.last_as_first);
  std::vector<Hypothesis> others = levels;
  others.back().point_noise = 1.5;
  const NoiseLevels unlike = noise_of(others);
  EXPECT_FALSE(unlike.last_as_first);
  RandomStream random(1);
  for (int i = 0; i < 20000; ++i) {
    const ContactPlace place{static_cast<float>(0.05 * random.normal() * random.uniform()),
                             static_cast<float>(2 * random.uniform() * random.uniform()),
                             static_cast<float>(0.1 * random.normal()),
                             static_cast<float>(1e5 * random.uniform())};
    for (const NoiseLevels& noise : {alike, unlike}) {
      EXPECT_TRUE(
          (likelihood_at_all(noise, growth, place) == expected(noise, growth, place)).all());
    }
  }
}

}  // namespace
}  // namespace palpate::localization
