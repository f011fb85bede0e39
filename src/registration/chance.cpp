// SPDX-License-Identifier: Apache-2.0
#include "palpate/registration/chance.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

namespace palpate::registration {
namespace {

constexpr int kBins = 64;  // of the gain of one correspondence, 0..1

using Masses = std::array<double, kBins + 1>;

/// Probability of each gain j / kBins, rounded up.
Masses gain_masses(int dimensions) {
  const auto above = [&](double x) { return std::pow(std::max(0.0, 1 - x), 0.5 * dimensions); };
  Masses masses{};
  for (int j = 1; j <= kBins; ++j) {
    masses[static_cast<std::size_t>(j)] =
        above(static_cast<double>(j - 1) / kBins) - above(static_cast<double>(j) / kBins);
  }
  return masses;
}

/// log of the Chernoff bound of P(sum of gains >= gain).
double log_chernoff(const Masses& masses, double rate, double gain) {
  double least = 0;
  for (double theta = 0.25; theta < 64; theta *= 1.2) {
    const double factor = std::exp(theta / kBins);
    double moment = 0, power = 1;
    for (int j = 1; j <= kBins; ++j) {
      power *= factor;
      moment += masses[static_cast<std::size_t>(j)] * power;
    }
    least = std::min(least, rate * (moment - 1) - theta * gain);
  }
  return least;
}

/// P(sum of gains >= gain) by Panjer's recursion.
double exact_tail(const Masses& masses, double rate, double gain) {
  const int bins = static_cast<int>(std::floor(gain * kBins));
  std::vector<double> density(static_cast<std::size_t>(bins), 0);
  if (bins == 0) return 1;
  density[0] = std::exp(-rate);
  double below = density[0];
  for (int s = 1; s < bins; ++s) {
    double sum = 0;
    for (int j = 1; j <= std::min(s, kBins); ++j) {
      sum += j * masses[static_cast<std::size_t>(j)] * density[static_cast<std::size_t>(s - j)];
    }
    density[static_cast<std::size_t>(s)] = rate / s * sum;
    below += density[static_cast<std::size_t>(s)];
  }
  return 1 - below;
}

}  // namespace

double expected_by_chance(const ChanceModel& model, double gain) {
  // Below this the difference 1 - P(less) is mere rounding, and the bound says enough.
  constexpr double kLogRounding = -25;
  if (!(gain > 0)) return model.triples;
  const Masses masses = gain_masses(model.dimensions);
  const double log_bound = log_chernoff(masses, model.rate, gain);
  const double tail =
      log_bound < kLogRounding || model.rate > 500
          ? std::exp(log_bound)
          : std::clamp(exact_tail(masses, model.rate, gain), 1e-15, std::exp(log_bound));
  return model.triples * tail;
}

}  // namespace palpate::registration
