// SPDX-License-Identifier: Apache-2.0
#include "localization/likelihood/contact_noise.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <ranges>

#include "localization/likelihood/evidence_term.hpp"

namespace palpate::localization {
namespace {

constexpr double kFalseVolume = 1e-3;  // m^3 in which a false contact may lie
constexpr double kWidestNormal = 0.6;  // rad

/// Of the noise scale's prior: the probability of each contact that its normal is an outlier. Next
/// to edges and in corners the point's noise takes the normal from one face to another.
constexpr double kOutlierShare = 0.125;

/// Without a normal, in any direction: 1 / 4 pi, the limit of the von Mises-Fisher density.
double peak_normal_density(double sn) {
  using std::numbers::pi;
  if (std::isinf(sn)) return 1 / (4 * pi);
  return 1 / (2 * pi * sn * sn * (1 - std::exp(-2 / (sn * sn))));
}

/// A wider normal than kWidestNormal is no less informative, but an infinite one carries nothing.
double informative_sigma(double normal_sigma) {
  return std::isinf(normal_sigma) ? normal_sigma : std::min(normal_sigma, kWidestNormal);
}

double true_to_false_odds(double false_share, double area, double sp, double sn) {
  const double false_density = 1 / (kFalseVolume * 4 * std::numbers::pi);
  return (1 - false_share) / false_share * peak_contact_density(area, sp, sn) / false_density;
}

}  // namespace

double normal_sigma_of(const tactile::Contact& contact) {
  return contact.has_normal() ? contact.normal_sigma : std::numeric_limits<double>::infinity();
}

double peak_contact_density(double area, double point_sigma, double normal_sigma) {
  const double point_density = 1 / (area * std::sqrt(2 * std::numbers::pi) * point_sigma);
  return point_density * peak_normal_density(informative_sigma(normal_sigma));
}

NoiseLevels make_noise(const geometry::ObjectModel& model, const Evidence& evidence,
                       const tactile::Contact& contact, const std::vector<Hypothesis>& levels,
                       double scale) {
  const auto count = static_cast<Eigen::Index>(levels.size());
  const double area = evidence.contact_area.value_or(model.area());
  NoiseLevels noise{NoiseArray::Zero(count), NoiseArray::Zero(count), NoiseArray::Zero(count),
                    NoiseArray::Zero(count)};
  if (contact.has_normal()) {
    noise.outlier_share = static_cast<float>(kOutlierShare * evidence.noise_scale_prior);
  }
  double greatest = 0, min_half_point = kNoBound, min_normal = kNoBound;
  for (Eigen::Index j = 0; j < count; ++j) {
    const Hypothesis& level = levels[static_cast<std::size_t>(j)];
    const double sp = scale * level.point_noise * contact.point_sigma;
    const double sn = informative_sigma(scale * level.normal_noise * normal_sigma_of(contact));
    const double odds = true_to_false_odds(evidence.false_contact_share, area, sp, sn);
    noise.half_point_precision[j] = static_cast<float>(0.5 / (sp * sp));
    noise.normal_precision[j] = static_cast<float>(1 / (sn * sn));
    noise.curvature_widening[j] = static_cast<float>(sp * sp / (sn * sn));
    noise.odds[j] = static_cast<float>(odds);
    greatest = std::max(greatest, odds);
    min_half_point = std::min(min_half_point, 0.5 / (sp * sp));
    min_normal = std::min(min_normal, 1 / (sn * sn));
  }
  noise.min_half_point_precision = static_cast<float>(min_half_point);
  noise.min_normal_precision = static_cast<float>(min_normal);
  noise.max_curvature_widening = noise.curvature_widening.maxCoeff();
  noise.cap = static_cast<float>(std::log1p(greatest));
  noise.inverse_peak = std::exp(-noise.cap);
  noise.stated_cap = std::log1p(noise.odds[0]);
  noise.last_as_first =
      std::ranges::all_of(levels | std::views::reverse | std::views::take(4), [&](const auto& l) {
        return l.point_noise == levels.front().point_noise &&
               l.normal_noise == levels.front().normal_noise;
      });
  return noise;
}

}  // namespace palpate::localization
