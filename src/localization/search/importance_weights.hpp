// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

namespace palpate::localization {

/// Weights exp(log_weight) relative to the largest. @param log_weights  at least one
inline std::vector<double> relative_weights(const std::vector<double>& log_weights) {
  const double largest = *std::max_element(log_weights.begin(), log_weights.end());
  std::vector<double> weights;
  weights.reserve(log_weights.size());
  for (const double w : log_weights) weights.push_back(std::exp(w - largest));
  return weights;
}

/// Effective sample size: the number of equally weighted samples that are worth as much.
inline double effective_sample_size(const std::vector<double>& weights) {
  double sum = 0, squares = 0;
  for (const double w : weights) {
    sum += w;
    squares += w * w;
  }
  return sum * sum / squares;
}

}  // namespace palpate::localization
