// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <fmt/format.h>

#include <string_view>

#include "palpate/core/error.hpp"

namespace palpate::touch {

/// Visitor of an options struct that refuses numbers outside their ranges.
struct OptionCheck {
  template <class Number>
  void operator()(std::string_view name, Number value, double low, double high,
                  std::string_view /*doc*/) const {
    const auto number = static_cast<double>(value);
    if (number >= low && number <= high) return;
    throw BadInput(fmt::format("{} must be within {}..{}, not {}", name, low, high, value));
  }
  void operator()(std::string_view /*name*/, bool /*value*/, std::string_view /*doc*/) const {}
};

/// The options, if all are within their ranges. @throws BadInput, naming the one that is not
template <class Options>
Options checked(Options options) {
  options.visit(OptionCheck{});
  return options;
}

}  // namespace palpate::touch
