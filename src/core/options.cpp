// SPDX-License-Identifier: Apache-2.0
#include "palpate/core/options.hpp"

#include <fmt/format.h>
#include <toml++/toml.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <sstream>

#include "palpate/core/error.hpp"

namespace palpate {
namespace {

std::size_t edit_distance(std::string_view a, std::string_view b) {
  std::vector<std::size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), std::size_t{0});
  for (std::size_t i = 1; i <= a.size(); ++i) {
    std::size_t diagonal = std::exchange(row[0], i);
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const std::size_t change = diagonal + (a[i - 1] != b[j - 1]);
      diagonal = row[j];
      row[j] = std::min({row[j] + 1, row[j - 1] + 1, change});
    }
  }
  return row.back();
}

const OptionField& find_field(const std::string& key, const std::vector<OptionField>& fields,
                              const std::string& where) {
  const auto distance = [&](const OptionField& field) { return edit_distance(key, field.key); };
  const auto nearest =
      std::min_element(fields.begin(), fields.end(),
                       [&](const auto& a, const auto& b) { return distance(a) < distance(b); });
  if (nearest == fields.end()) throw BadInput(fmt::format("{}: unknown key {}", where, key));
  if (nearest->key != key) {
    throw BadInput(fmt::format("{}: unknown key {}; did you mean {}?", where, key, nearest->key));
  }
  return *nearest;
}

void check_range(const OptionField& field, double value, const std::string& where) {
  if (!(value >= field.low && value <= field.high)) {
    throw BadInput(fmt::format("{}: {} = {} is outside {}..{} ({})", where, field.key, value,
                               field.low, field.high, field.doc));
  }
}

/// Puts a TOML value into a field.
class Assign {
 public:
  Assign(const OptionField& field, const toml::node& node, const std::string& where)
      : field_(field), node_(node), where_(where) {}

  void operator()(int* target) const {
    const auto value = node_.value_exact<std::int64_t>();
    if (!value) wrong_type("a whole number");
    check_range(field_, static_cast<double>(*value), where_);
    *target = static_cast<int>(*value);
  }
  void operator()(double* target) const {
    const auto value = node_.is_number() ? node_.value<double>() : std::nullopt;
    if (!value) wrong_type("a number");
    check_range(field_, *value, where_);
    *target = *value;
  }
  void operator()(bool* target) const {
    const auto value = node_.value_exact<bool>();
    if (!value) wrong_type("true or false");
    *target = *value;
  }
  void operator()(std::string* target) const {
    const auto value = node_.value_exact<std::string>();
    if (!value) wrong_type("a string");
    *target = *value;
  }

 private:
  [[noreturn]] void wrong_type(std::string_view wanted) const {
    std::ostringstream given;
    node_.visit([&](const auto& node) { given << node; });
    throw BadInput(fmt::format("{}: {} = {} is not {}", where_, field_.key, given.str(), wanted));
  }
  const OptionField& field_;
  const toml::node& node_;
  const std::string& where_;
};

void assign_table(const toml::table& table, const std::string& prefix, const std::string& name,
                  const std::vector<OptionField>& fields) {
  for (const auto& [key, node] : table) {
    const std::string full = prefix + std::string(key.str());
    if (const toml::table* section = node.as_table()) {
      assign_table(*section, full + ".", name, fields);
      continue;
    }
    const std::string where = fmt::format("{}:{}", name, node.source().begin.line);
    const OptionField& field = find_field(full, fields, where);
    std::visit(Assign(field, node, where), field.value);
  }
}

toml::table parse(std::string_view text, const std::string& name) {
  try {
    return toml::parse(text);
  } catch (const toml::parse_error& error) {
    throw BadInput(fmt::format("{}:{}: {}", name, error.source().begin.line, error.description()));
  }
}

struct Printer {
  std::string operator()(const int* value) const { return fmt::format("{}", *value); }
  std::string operator()(const bool* value) const { return *value ? "true" : "false"; }
  std::string operator()(const double* value) const {
    const std::string text = fmt::format("{}", *value);
    const bool whole = text.find_first_of(".en") == std::string::npos;
    return whole ? text + ".0" : text;
  }
  std::string operator()(const std::string* value) const {
    std::ostringstream out;
    out << toml::value<std::string>(*value);
    return out.str();
  }
};

}  // namespace

void load_toml_text(std::string_view text, const std::string& name,
                    const std::vector<OptionField>& fields) {
  assign_table(parse(text, name), "", name, fields);
}

void apply_setting_text(std::string_view assignment, const std::vector<OptionField>& fields) {
  const auto equals = assignment.find('=');
  if (equals == std::string_view::npos || equals == 0) {
    throw BadInput(fmt::format("--set {}: not of the form KEY=VALUE", assignment));
  }
  const std::string where = fmt::format("--set {}", assignment);
  const OptionField& field = find_field(std::string(assignment.substr(0, equals)), fields, where);
  std::string value(assignment.substr(equals + 1));
  if (std::holds_alternative<std::string*>(field.value)) {
    *std::get<std::string*>(field.value) = value;
    return;
  }
  const toml::table table = parse("value = " + value, where);
  std::visit(Assign(field, *table.get("value"), where), field.value);
}

std::string to_toml_text(const std::vector<OptionField>& fields) {
  // Keys outside sections must come first in TOML; within a section the order of visit() stays.
  std::vector<const OptionField*> ordered;
  for (const auto& field : fields) ordered.push_back(&field);
  const auto section_of = [](const OptionField& field) {
    const auto dot = field.key.rfind('.');
    return dot == std::string::npos ? std::string() : field.key.substr(0, dot);
  };
  std::stable_sort(ordered.begin(), ordered.end(),
                   [&](const auto* a, const auto* b) { return section_of(*a) < section_of(*b); });
  std::string text, section;
  for (const OptionField* field : ordered) {
    if (section_of(*field) != section) {
      section = section_of(*field);
      text += fmt::format("\n[{}]\n", section);
    }
    const std::string name = field->key.substr(section.empty() ? 0 : section.size() + 1);
    text += fmt::format("{} = {}  # {}\n", name, std::visit(Printer(), field->value), field->doc);
  }
  return text;
}

}  // namespace palpate
