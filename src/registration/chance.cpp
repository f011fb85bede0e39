// SPDX-License-Identifier: Apache-2.0
#include "palpate/registration/chance.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace palpate::registration {
namespace {

double log_unit_ball(double dimensions) {
  return dimensions / 2 * std::log(std::numbers::pi) - std::lgamma(dimensions / 2 + 1);
}

/// log of the volume of residuals (modulo the pose) in which a triple passes the gates of
/// ConsistencyGraph, by Monte Carlo over random triples on an ellipsoid of the size of a hand, to
/// some 20 %: with positions alone 6.5, with normals (of 5 deg) 1500.
double log_gate_volume(int dimensions) { return std::log(dimensions > 3 ? 1500.0 : 6.5); }

}  // namespace

double expected_by_chance(const ChanceModel& model, double squares, int count) {
  if (count < 3) return std::numeric_limits<double>::infinity();
  if (count == 3) return model.triples;
  const double k = count, freedom = model.dimensions * k - 6;
  const double log_volume = log_unit_ball(freedom) +
                            freedom / 2 * std::log(std::max(squares, 1e-12)) -
                            log_gate_volume(model.dimensions);
  const double log_others =
      (k - 3) * (std::log(model.rate) - log_unit_ball(model.dimensions)) - std::lgamma(k - 2);
  const double log_choices = std::log(k * (k - 1) * (k - 2) / 6);
  const double log_expected =
      std::log(model.triples) + 3 * std::log(k / 3) + log_volume + log_others - log_choices;
  return std::exp(std::min(log_expected, 700.0));
}

}  // namespace palpate::registration
