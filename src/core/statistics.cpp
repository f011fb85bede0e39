// SPDX-License-Identifier: Apache-2.0
#include "palpate/core/statistics.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <boost/math/distributions/students_t.hpp>
#include <cmath>
#include <numeric>

#include "palpate/core/error.hpp"

namespace palpate {
namespace {

constexpr double kNormalQuantile = 1.959963984540054;  // 97.5 %

void need(const std::vector<double>& values, std::size_t least) {
  if (values.size() < least) {
    throw BadInput(fmt::format("{} values given, at least {} needed", values.size(), least));
  }
  for (const double value : values) {
    if (std::isnan(value)) throw BadInput("a statistic of values with nan among them");
  }
}

}  // namespace

double mean(const std::vector<double>& values) {
  need(values, 1);
  return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}

double standard_deviation(const std::vector<double>& values) {
  need(values, 2);
  const double center = mean(values);
  double sum = 0;
  for (const double value : values) sum += (value - center) * (value - center);
  return std::sqrt(sum / static_cast<double>(values.size() - 1));
}

double quantile(std::vector<double> values, double share) {
  need(values, 1);
  if (!(share >= 0 && share <= 1)) {
    throw BadInput(fmt::format("quantile share {}: not 0..1", share));
  }
  std::sort(values.begin(), values.end());
  const double place = share * static_cast<double>(values.size() - 1);
  const auto below = static_cast<std::size_t>(place);
  const auto above = std::min(below + 1, values.size() - 1);
  const double fraction = place - static_cast<double>(below);
  // Without this an infinite value beside the quantile would turn it into nan.
  if (fraction == 0 || values[below] == values[above]) return values[below];
  return std::lerp(values[below], values[above], fraction);
}

Interval wilson_interval(std::size_t successes, std::size_t trials) {
  if (trials == 0 || successes > trials) {
    throw BadInput(fmt::format("a rate of {} successes in {} trials", successes, trials));
  }
  const double n = static_cast<double>(trials);
  const double p = static_cast<double>(successes) / n;
  const double z2 = kNormalQuantile * kNormalQuantile;
  const double center = (p + z2 / (2 * n)) / (1 + z2 / n);
  const double half =
      kNormalQuantile / (1 + z2 / n) * std::sqrt(p * (1 - p) / n + z2 / (4 * n * n));
  // The ends are exactly 0 and 1 there; rounding must not say otherwise.
  return {successes == 0 ? 0.0 : center - half, successes == trials ? 1.0 : center + half};
}

Interval mean_interval(const std::vector<double>& values) {
  const double n = static_cast<double>(values.size());
  const double error = standard_deviation(values) / std::sqrt(n);
  const boost::math::students_t distribution(n - 1);
  const double half = boost::math::quantile(distribution, 0.975) * error;
  return {mean(values) - half, mean(values) + half};
}

std::vector<std::size_t> histogram(const std::vector<double>& values, double low, double high,
                                   std::size_t bins) {
  need(values, 1);
  if (bins == 0 || !(low < high)) {
    throw BadInput(fmt::format("a histogram of {} bins from {} to {}", bins, low, high));
  }
  std::vector<std::size_t> counts(bins, 0);
  for (const double value : values) {
    if (!(value >= low && value <= high)) continue;
    const double place = (value - low) / (high - low) * static_cast<double>(bins);
    ++counts[std::min(static_cast<std::size_t>(place), bins - 1)];
  }
  return counts;
}

}  // namespace palpate
