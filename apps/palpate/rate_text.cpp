// SPDX-License-Identifier: Apache-2.0
#include "rate_text.hpp"

#include <fmt/format.h>

#include "palpate/core/statistics.hpp"

namespace palpate::app {

nlohmann::json rate(std::size_t count, std::size_t trials) {
  if (trials == 0) return nullptr;
  return static_cast<double>(count) / static_cast<double>(trials);
}

std::string rate_text(std::size_t count, std::size_t trials) {
  if (trials == 0) return "-";
  const auto interval = wilson_interval(count, trials);
  return fmt::format("{:.2f} [{:.2f}, {:.2f}]",
                     static_cast<double>(count) / static_cast<double>(trials), interval.low,
                     interval.high);
}

std::string median_text(const std::vector<double>& values) {
  return values.empty() ? "-" : fmt::format("{:.1f}", median(values));
}

std::string counts_text(const std::map<std::string, std::size_t>& counts) {
  std::string text;
  for (const auto& [name, count] : counts) {
    text += fmt::format("{}{} {}", text.empty() ? "" : ", ", name, count);
  }
  return text.empty() ? "-" : text;
}

nlohmann::json quantiles_json(const std::vector<double>& values) {
  if (values.empty()) return {{"median", nullptr}, {"p95", nullptr}};
  return {{"median", median(values)}, {"p95", quantile(values, 0.95)}};
}

}  // namespace palpate::app
