// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <toml++/toml.h>

#include <algorithm>
#include <cmath>
#include <sstream>

#include "palpate/core/options.hpp"

namespace palpate {
namespace {

std::string number_text(double value) {
  std::string text = fmt::format("{}", value);  // the shortest that reads back exactly
  const bool looks_integer = text.find_first_of(".en") == std::string::npos;
  return looks_integer ? text + ".0" : text;
}

template <class Integer>
std::string number_text(Integer value) {
  return fmt::format("{}", value);
}

std::string toml_string(const std::string& value) {
  std::ostringstream text;
  text << toml::value<std::string>(value);
  return text.str();
}

/// Fills in type, value and range.
struct Describer {
  OptionInfo& info;

  void operator()(const bool* value) const {
    info.type = "bool";
    info.value = *value ? "true" : "false";
  }
  void operator()(const std::string* value) const {
    info.type = "string";
    info.value = toml_string(*value);
  }
  template <class Number>
  void operator()(const RangedOption<Number>& option) const {
    info.type = std::is_integral_v<Number> ? "integer" : "number";
    info.value = number_text(*option.value);
    info.range = fmt::format("{} .. {}", option.low, option.high);
  }
};

std::string section_of(const std::string& key) {
  const auto dot = key.rfind('.');
  return dot == std::string::npos ? "" : key.substr(0, dot);
}

std::string name_of(const std::string& key) {
  const auto dot = key.rfind('.');
  return dot == std::string::npos ? key : key.substr(dot + 1);
}

std::string section_text(const std::string& section, const std::vector<OptionInfo>& options) {
  std::string text = section.empty() ? "" : fmt::format("\n[{}]\n", section);
  for (const auto& option : options) {
    if (section_of(option.key) != section) continue;
    const std::string range = option.range.empty() ? "" : fmt::format(" ({})", option.range);
    text +=
        fmt::format("{:<32}  # {}{}\n", fmt::format("{} = {}", name_of(option.key), option.value),
                    option.doc, range);
  }
  return text;
}

}  // namespace

std::vector<OptionInfo> describe(const std::vector<OptionField>& fields) {
  std::vector<OptionInfo> infos;
  for (const auto& field : fields) {
    OptionInfo& info = infos.emplace_back();
    info.key = field.key;
    info.doc = field.doc;
    std::visit(Describer{info}, field.value);
  }
  return infos;
}

std::string fields_to_toml(const std::vector<OptionField>& fields) {
  const auto options = describe(fields);
  std::vector<std::string> sections{""};  // the root first: TOML has no way back to it
  for (const auto& option : options) {
    const std::string section = section_of(option.key);
    if (std::find(sections.begin(), sections.end(), section) == sections.end()) {
      sections.push_back(section);
    }
  }
  std::string text;
  for (const auto& section : sections) text += section_text(section, options);
  return text;
}

}  // namespace palpate
