// SPDX-License-Identifier: Apache-2.0
#include "localization/likelihood/contact_likelihood.hpp"

#include <array>
#include <cstring>

#include "core/lanes.hpp"

namespace palpate::localization {
namespace {

constexpr std::size_t kFours = kMaxNoiseHypotheses / 4;
static_assert(4 * kFours == kMaxNoiseHypotheses);
using Fours = std::array<Floats4, kFours>;

Fours fours_of(const NoiseArray& levels) {
  Fours fours;
  std::memcpy(fours.data(), levels.data(), sizeof(fours));
  return fours;
}

/// e^x, within 2 units in the last place from e^-86.5 on, and that below; for x up to 80. After
/// Cephes, as Eigen's, whose bits it has.
Floats4 exp_of(Floats4 x) {
  constexpr float kMinExponent = -86.5F,
                  kMaxExponent = 80;  // powers of two that are normal numbers
  constexpr int kExponentBit = 23;
  x = x > kMinExponent ? x : Floats4{} + kMinExponent;
  x = x < kMaxExponent ? x : Floats4{} + kMaxExponent;
  const Floats4 scaled = x * 1.44269504088896341F + 0.5F;
  Ints4 power = __builtin_convertvector(scaled, Ints4);
  power += Ints4(__builtin_convertvector(power, Floats4) > scaled);  // rounded down
  const Floats4 whole = __builtin_convertvector(power, Floats4);
  const Floats4 r = whole * 2.12194440e-4F + (whole * -0.693359375F + x);
  const Floats4 r2 = r * r, r3 = r2 * r;
  const Floats4 high = (1.9875691500E-4F * r + 1.3981999507E-3F) * r + 8.3334519073E-3F;
  const Floats4 low = (4.1665795894E-2F * r + 1.6666665459E-1F) * r + 5.0000001201E-1F;
  const Floats4 y = (high * r3 + low) * r2 + (r + 1);
  return Floats4(Ints4(y) + (power << kExponentBit));
}

}  // namespace

NoiseArray likelihood_at_all(const NoiseLevels& noise, const NoiseArray& growth,
                             const ContactPlace& place) {
  const Fours widening = fours_of(noise.curvature_widening), odds = fours_of(noise.odds);
  const Fours normal_precision = fours_of(noise.normal_precision);
  const float far_share = noise.outlier_share / kOutlierVariance;
  Fours weights;  // odds of the contact by its normal alone
  for (std::size_t i = 0; i < kFours; ++i) {
    if (i + 1 == kFours && noise.last_as_first) {
      weights[i] = Floats4{} + weights[0][0];
      break;
    }
    const Floats4 wider = 1 + widening[i] * place.squared_curvature;
    const Floats4 q = -(place.normal * normal_precision[i] / wider);
    const Floats4 normal =
        (1 - noise.outlier_share) * exp_of(q) + far_share * exp_of(q / kOutlierVariance);
    weights[i] = odds[i] / wider * normal;
  }
  const Fours steps = fours_of(growth), point_precision = fours_of(noise.half_point_precision);
  Fours result;
  for (std::size_t i = 0; i < kFours; ++i) {
    const Floats4 distance = place.distance + steps[i] * place.scale_derivative;
    const Floats4 near = exp_of(-(distance * distance) * point_precision[i]);
    result[i] = (1 + weights[i] * near) * noise.inverse_peak;
  }
  NoiseArray likelihood(growth.size());
  std::memcpy(likelihood.data(), result.data(), sizeof(result));
  return likelihood;
}

}  // namespace palpate::localization
