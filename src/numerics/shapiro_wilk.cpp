// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <boost/math/distributions/normal.hpp>
#include <cmath>
#include <initializer_list>
#include <numbers>

#include "palpate/core/error.hpp"
#include "palpate/numerics/hypothesis_tests.hpp"

namespace palpate::numerics {
namespace {

const boost::math::normal kNormal;

/// Polynomial with its coefficients from the constant one on.
double polynomial(std::initializer_list<double> coefficients, double x) {
  double sum = 0, power = 1;
  for (const double c : coefficients) {
    sum += c * power;
    power *= x;
  }
  return sum;
}

/// Weights of the ordered values; antisymmetric, of unit length.
std::vector<double> weights(std::size_t n) {
  const double count = static_cast<double>(n);
  if (n == 3) return {-std::sqrt(0.5), 0, std::sqrt(0.5)};
  std::vector<double> m(n);
  double square = 0;
  for (std::size_t i = 0; i < n; ++i) {
    m[i] = quantile(kNormal, (static_cast<double>(i) + 0.625) / (count + 0.25));
    square += m[i] * m[i];
  }
  const double u = 1 / std::sqrt(count), length = std::sqrt(square);
  const std::size_t ends = n > 5 ? 2 : 1;  // whose weights are corrected
  const double last =
      polynomial({m[n - 1] / length, 0.221157, -0.147981, -2.07119, 4.434685, -2.706056}, u);
  const double second =
      polynomial({m[n - 2] / length, 0.042981, -0.293762, -1.752461, 5.682633, -3.582633}, u);
  double rest = square - 2 * m[n - 1] * m[n - 1], left = 1 - 2 * last * last;
  if (ends == 2) {
    rest -= 2 * m[n - 2] * m[n - 2];
    left -= 2 * second * second;
  }
  for (double& value : m) value /= std::sqrt(rest / left);
  m[n - 1] = last;
  m[0] = -last;
  if (ends == 2) {
    m[n - 2] = second;
    m[1] = -second;
  }
  return m;
}

/// p of a W of n values, by Royston's normalising transformation.
double significance(double w, std::size_t n) {
  const double count = static_cast<double>(n);
  if (n == 3) {
    const double p = 6 / std::numbers::pi * (std::asin(std::sqrt(w)) - std::asin(std::sqrt(0.75)));
    return std::max(p, 0.0);
  }
  double y = std::log(1 - w), center = 0, spread = 1;
  if (n <= 11) {
    const double gamma = polynomial({-2.273, 0.459}, count);
    if (y >= gamma) return 0;
    y = -std::log(gamma - y);
    center = polynomial({0.544, -0.39978, 0.025054, -6.714e-4}, count);
    spread = std::exp(polynomial({1.3822, -0.77857, 0.062767, -0.0020322}, count));
  } else {
    const double x = std::log(count);
    center = polynomial({-1.5861, -0.31082, -0.083751, 0.0038915}, x);
    spread = std::exp(polynomial({-0.4803, -0.082676, 0.0030302}, x));
  }
  return cdf(complement(kNormal, (y - center) / spread));
}

}  // namespace

TestResult shapiro_wilk(const std::vector<double>& values) {
  constexpr std::size_t kLeast = 3, kMost = 5000;  // what Royston's p holds for
  if (values.size() < kLeast || values.size() > kMost) {
    throw palpate::BadInput(
        fmt::format("normality of {} values, {} to {} needed", values.size(), kLeast, kMost));
  }
  std::vector<double> sorted = values;
  std::sort(sorted.begin(), sorted.end());
  const double center = mean(values);
  const auto a = weights(values.size());
  double projected = 0, square = 0;
  for (std::size_t i = 0; i < sorted.size(); ++i) {
    projected += a[i] * sorted[i];
    square += (sorted[i] - center) * (sorted[i] - center);
  }
  if (!(square > 0))
    throw palpate::BadInput(fmt::format("normality of values all equal to {}", center));
  const double w = std::min(projected * projected / square, 1.0);
  return {w, w < 1 ? significance(w, values.size()) : 1.0};
}

}  // namespace palpate::numerics
