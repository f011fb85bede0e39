// SPDX-License-Identifier: Apache-2.0
#include "plotting/plot_axis.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "palpate/core/error.hpp"

namespace palpate::plotting {
namespace {

constexpr double kAir = 0.04;             // of the data's span, at each end
constexpr double kMinSpan = 1e-9;         // of the larger limit: keeps ticks apart in a double
constexpr double kSmallestSpan = 1e-290;  // keeps the step from vanishing

/// The round number nearest to the span of one step (Heckbert, Graphics Gems, 1990).
double round_step(double span, int count) {
  const double raw = span / count;
  const double power = std::pow(10.0, std::floor(std::log10(raw)));
  const double factor = raw / power;
  return power * (factor < 1.5 ? 1 : factor < 3 ? 2 : factor < 7 ? 5 : 10);
}

std::string with_real_minus(std::string text) {
  if (text.starts_with('-')) text.replace(0, 1, "\u2212");
  return text;
}

std::string superscript(int number) {
  static constexpr std::string_view kDigits[] = {"⁰", "¹", "²", "³", "⁴", "⁵", "⁶", "⁷", "⁸", "⁹"};
  std::string text;
  for (const char c : std::to_string(number)) {
    text += c == '-' ? std::string_view("⁻") : kDigits[c - '0'];
  }
  return text;
}

std::string scientific(double value) {
  const int exponent = static_cast<int>(std::floor(std::log10(std::abs(value)) + 1e-9));
  const std::string factor = fmt::format("{:.6g}", value / std::pow(10.0, exponent));
  return with_real_minus(factor == "1" ? "10" + superscript(exponent)
                                       : factor + "·10" + superscript(exponent));
}

std::string label(double value, double step, double largest) {
  if (value == 0) return "0";
  if (largest >= 1e6 || step < 1e-4) return scientific(value);
  const int decimals = std::max(0, -static_cast<int>(std::floor(std::log10(step) + 1e-9)));
  return with_real_minus(fmt::format("{:.{}f}", value, decimals));
}

std::vector<Tick> linear_ticks(const Scale& scale, int count) {
  const double step = round_step(scale.high() - scale.low(), count);
  const double largest = std::max(std::abs(scale.low()), std::abs(scale.high()));
  std::vector<Tick> result;
  const double last = std::floor(scale.high() / step + 1e-6);
  for (double i = std::ceil(scale.low() / step - 1e-6); i <= last; ++i) {
    result.push_back({i * step, label(i * step, step, largest)});
  }
  return result;
}

int decade_below(double value) { return static_cast<int>(std::floor(std::log10(value) + 1e-9)); }

std::string decade_label(double value) {
  return value >= 0.999e-3 && value < 1e5 ? fmt::format("{:.6g}", value) : scientific(value);
}

/// Factors times the powers of ten; with many powers only every so many of them.
std::vector<Tick> log_ticks(const Scale& scale, const std::vector<double>& factors, int stride) {
  std::vector<Tick> result;
  const int last = decade_below(scale.high());
  for (int k = decade_below(scale.low()); k <= last; ++k) {
    for (const double factor : factors) {
      const double value = factor * std::pow(10.0, k);
      if (k % stride == 0 && scale.shows(value)) result.push_back({value, decade_label(value)});
    }
  }
  return result;
}

void widen(double& low, double& high, bool logarithmic) {
  const double air = kAir * (high - low);
  const double least = std::max(kMinSpan * std::max(std::abs(low), std::abs(high)), kSmallestSpan);
  if (logarithmic) {
    const double factor = high > low * 1.001 ? std::pow(high / low, kAir) : 2;
    low /= factor;
    high *= factor;
  } else if (high - low <= least) {
    const double half = low == 0 ? 1 : std::max(0.1 * std::abs(low), kSmallestSpan);
    low -= half;
    high += half;
  } else {
    // What never falls below zero starts there rather than a little below.
    low = low >= 0 && low < air ? 0 : low - air;
    high = high <= 0 && -high < air ? 0 : high + air;
  }
}

}  // namespace

bool drawable(const PlotAxis& axis, double value) {
  return std::isfinite(value) && !(axis.logarithmic && value <= 0);
}

void Extent::include(const PlotAxis& axis, double value) {
  if (!drawable(axis, value)) return;
  low = std::min(low, value);
  high = std::max(high, value);
}

void Scale::place(double at_low, double at_high) {
  at_low_ = at_low;
  at_high_ = at_high;
}

double Scale::operator()(double value) const {
  const double share = logarithmic_
                           ? (std::log(value) - std::log(low_)) / (std::log(high_) - std::log(low_))
                           : (value - low_) / (high_ - low_);
  // Far beyond the picture the exact place is of no use, and renderers fail at huge numbers.
  return at_low_ + std::clamp(share, -1e3, 1e3) * (at_high_ - at_low_);
}

Scale make_scale(const PlotAxis& axis, Extent extent, std::string_view name) {
  double low = extent.low, high = extent.high;
  widen(low, high, axis.logarithmic);
  low = axis.low.value_or(low);
  high = axis.high.value_or(high);
  const bool spans = std::isfinite(high - low) &&
                     high - low > kMinSpan / 10 * std::max(std::abs(low), std::abs(high)) &&
                     high - low >= kSmallestSpan / 10;
  if (!spans || (axis.logarithmic && !(low > 0))) {
    throw palpate::BadInput(fmt::format("the {} axis of a plot cannot run from {} to {}{}", name,
                                        low, high, axis.logarithmic ? " logarithmically" : ""));
  }
  return {low, high, axis.logarithmic};
}

std::vector<Tick> ticks(const Scale& scale, int count) {
  if (!scale.logarithmic()) return linear_ticks(scale, count);
  const double decades = std::log10(scale.high()) - std::log10(scale.low());
  const int stride = std::max(1, static_cast<int>(std::ceil(decades / (count + 2))));
  for (const auto& factors : {std::vector<double>{1}, {1, 2, 5}, {1, 2, 3, 4, 5, 6, 7, 8, 9}}) {
    auto found = log_ticks(scale, factors, stride);
    if (found.size() >= 3) return found;
  }
  return linear_ticks(scale, count);
}

std::vector<double> minor_ticks(const Scale& scale) {
  std::vector<double> result;
  if (!scale.logarithmic() || scale.high() / scale.low() > 1e9) return result;
  for (const Tick& tick : log_ticks(scale, {2, 3, 4, 5, 6, 7, 8, 9}, 1)) {
    result.push_back(tick.value);
  }
  return result;
}

}  // namespace palpate::plotting
