// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <fmt/format.h>

#include <string_view>

#include "palpate/core/error.hpp"

namespace palpate {

/// The visitor of an options struct that was filled by a program and not by parse_toml: refuses
/// numbers outside their ranges.
struct OptionCheck {
  template <class Number>
  void operator()(std::string_view name, Number value, double low, double high,
                  std::string_view /*doc*/) const {
    const auto number = static_cast<double>(value);
    if (number >= low && number <= high) return;
    throw BadInput(fmt::format("{} must be within {}..{}, not {}", name, low, high, value));
  }
  template <class Word>  // bool, string
  void operator()(std::string_view /*name*/, const Word& /*value*/,
                  std::string_view /*doc*/) const {}
  template <class... Option>
  void expert(std::string_view name, Option&&... option) const {
    (*this)(name, option...);
  }
  template <class Options>
  void section(std::string_view /*name*/, Options& nested) const {
    nested.visit(*this);
  }
  template <class Options>
  void expert_section(std::string_view /*name*/, Options& nested) const {
    nested.visit(*this);
  }
};

/// The options, if all are within their ranges.
/// @throws BadInput naming the one that is not
template <class Options>
Options checked(Options options) {
  options.visit(OptionCheck{});
  return options;
}

}  // namespace palpate
