// SPDX-License-Identifier: Apache-2.0
#include "palpate/core/options.hpp"

#include <fmt/format.h>
#include <toml++/toml.h>

#include <algorithm>
#include <charconv>
#include <limits>
#include <optional>

#include "core/renamed_options.hpp"
#include "palpate/core/csv.hpp"
#include "palpate/core/error.hpp"
#include "palpate/core/spelling.hpp"
#include "palpate/core/unknown_option.hpp"

namespace palpate {
namespace {

constexpr auto kLargestInteger = std::numeric_limits<std::int64_t>::max();  // of TOML

/// A value as the user wrote it: `text` for messages; monostate if it is no scalar.
struct Written {
  std::variant<std::monostate, bool, std::int64_t, double, std::string> value;
  std::string text;
};

/// Assigns a Written to each kind of field. @throws BadInput, one line
class Assigner {
 public:
  Assigner(const OptionField& field, const Written& written, const std::string& where)
      : field_(field), written_(written), where_(where) {}

  void operator()(bool* target) const { *target = get<bool>("true or false"); }
  void operator()(std::string* target) const { *target = get<std::string>("a string"); }

  void operator()(const RangedOption<double>& target) const {
    const auto* integer = std::get_if<std::int64_t>(&written_.value);
    const double value = integer ? static_cast<double>(*integer) : get<double>("a number");
    if (!(value >= target.low && value <= target.high)) fail_range(target.low, target.high);
    *target.value = value;
  }

  template <class Integer>
  void operator()(const RangedOption<Integer>& target) const {
    const std::int64_t value = get<std::int64_t>("an integer");
    if (std::cmp_less(value, target.low) || std::cmp_greater(value, target.high)) {
      fail_range(target.low, target.high);
    }
    *target.value = static_cast<Integer>(value);
  }

 private:
  template <class T>
  const T& get(std::string_view wanted) const {
    if (const T* value = std::get_if<T>(&written_.value)) return *value;
    throw BadInput(fmt::format("{}{} = {} is not {}", where_, field_.key, written_.text, wanted));
  }

  template <class Number>
  [[noreturn]] void fail_range(Number low, Number high) const {
    throw BadInput(fmt::format("{}{} = {} is outside {} .. {} ({})", where_, field_.key,
                               written_.text, low, high, field_.doc));
  }

  const OptionField& field_;
  const Written& written_;
  const std::string& where_;
};

std::string_view last_part(std::string_view key) { return key.substr(key.rfind('.') + 1); }

/// The key from the last dots on, of which there are at most so many: "b.c" of "a.b.c" with one.
std::string_view last_parts(std::string_view key, std::ptrdiff_t dots) {
  std::size_t from = key.size();
  for (std::ptrdiff_t n = 0; n <= dots; ++n) {
    const auto dot = from == 0 ? key.npos : key.rfind('.', from - 1);
    if (dot == key.npos) return key;
    from = dot;
  }
  return key.substr(from + 1);
}

/// Users also write only the section or only what stands in it, "height" for "lift.height", or add
/// or omit the sections above, "grasp.friction" for "friction".
double key_distance(std::string_view key, std::string_view known) {
  constexpr double kOtherSection = 0.1;  // so that one of the section that was given comes first
  const double whole = spelling_distance(key, known);
  if (key.find('.') != std::string_view::npos) {
    const double last = spelling_distance(last_part(key), last_part(known));
    // The section alone makes no likeness: world.object_scale is not world.biotacs.
    if (last > kLikelyMeant) return 1;
    const auto dots = std::min(std::ranges::count(key, '.'), std::ranges::count(known, '.'));
    return std::min(
        whole, kOtherSection + spelling_distance(last_parts(key, dots), last_parts(known, dots)));
  }
  return std::min({whole, spelling_distance(key, known.substr(0, known.rfind('.'))),
                   spelling_distance(key, last_part(known))});
}

std::string suggestion(std::string_view key, const std::vector<OptionField>& fields) {
  const auto distance = [&](const OptionField& field) { return key_distance(key, field.key); };
  const auto nearest = std::ranges::min_element(fields, {}, distance);
  if (nearest == fields.end() || distance(*nearest) > kLikelyMeant) return "";
  return fmt::format("; did you mean {}?", nearest->key);
}

/// What a key of an earlier version may be called now: renamed, in the expert section, or both.
const OptionField* renamed_field(std::string_view key, const std::vector<OptionField>& fields) {
  const std::string renamed = renamed_option(key), expert(kExpertSection);
  for (const std::string& name : {renamed, expert + std::string(key), expert + renamed}) {
    const auto found = std::ranges::find(fields, name, &OptionField::key);
    if (found != fields.end()) return &*found;
  }
  return nullptr;
}

/// @return nothing for an option that is gone, where that is accepted
const OptionField* find_field(std::string_view key, const std::vector<OptionField>& fields,
                              const std::string& where, Earlier accept) {
  const auto found = std::find_if(fields.begin(), fields.end(),
                                  [&](const OptionField& field) { return field.key == key; });
  if (found != fields.end()) return &*found;
  const OptionField* now = renamed_field(key, fields);
  if (now && accept == Earlier::accepted) return now;
  if (now) throw BadInput(fmt::format("{}option {} is now {}", where, key, now->key));
  if (const std::string_view reason = removed_option(key); !reason.empty()) {
    if (accept == Earlier::accepted) return nullptr;
    throw UnknownOption(fmt::format("{}option {} is gone: {}", where, key, reason),
                        std::string(key));
  }
  throw UnknownOption(
      fmt::format("{}unknown option {}{}", where, key, suggestion(renamed_option(key), fields)),
      std::string(key));
}

void assign(const OptionField& field, const Written& written, const std::string& where) {
  std::visit(Assigner(field, written, where), field.value);
}

template <class Node>
std::string text_of(const Node& node) {
  std::ostringstream text;
  text << node;
  return text.str();
}

Written written_in_toml(const toml::node& node) {
  if (const auto* value = node.as_boolean()) return {value->get(), text_of(*value)};
  if (const auto* value = node.as_integer()) return {value->get(), text_of(*value)};
  if (const auto* value = node.as_floating_point()) return {value->get(), text_of(*value)};
  if (const auto* value = node.as_string()) return {value->get(), text_of(*value)};
  std::ostringstream type;
  type << node.type();
  return {{}, fmt::format("({})", type.str())};
}

template <class Number>
std::optional<Number> parse_number(std::string_view text) {
  Number number{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (error != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return number;
}

Written written_in_setting(const OptionField& field, std::string_view text) {
  Written written{std::string(text), std::string(text)};
  if (std::holds_alternative<std::string*>(field.value)) return written;
  if (text == "true" || text == "false") {
    written.value = text == "true";
  } else if (const auto integer = parse_number<std::int64_t>(text)) {
    written.value = *integer;
  } else if (const auto number = parse_number<double>(text)) {
    written.value = *number;
  }
  return written;
}

std::string place(std::string_view source, const toml::source_region& region) {
  return fmt::format("{}:{}: ", source, region.begin.line);
}

/// Whether some option is in the section, by its present or an earlier name, or was.
bool is_section(const std::string& key, const std::vector<OptionField>& fields) {
  if (!removed_option(key + ".").empty()) return true;
  const std::string prefix = renamed_option(key + ".");
  return std::any_of(fields.begin(), fields.end(), [&](const OptionField& field) {
    const bool expert = field.key.starts_with(kExpertSection);
    return field.key.starts_with(prefix) ||
           (expert &&
            std::string_view(field.key).substr(kExpertSection.size()).starts_with(prefix));
  });
}

void assign_table(const toml::table& table, const std::string& prefix, std::string_view source,
                  const std::vector<OptionField>& fields, Earlier accept) {
  for (const auto& [name, node] : table) {
    const std::string key = prefix + std::string(name.str());
    if (node.is_table() && is_section(key, fields)) {
      assign_table(*node.as_table(), key + ".", source, fields, accept);
    } else {
      const std::string where = place(source, name.source());
      const OptionField* const field = find_field(key, fields, where, accept);
      if (field) assign(*field, written_in_toml(node), where);
    }
  }
}

/// The TOML library bounds the nesting of arrays, but not that of dotted keys, and it calls itself
/// once a level. @throws BadInput for a text that nests deeper than any options do
void check_depth(std::string_view text, std::string_view source) {
  constexpr int kMaxOpen = 32, kMaxDots = 200;  // in all; in a line
  int open = 0, dots = 0;
  for (const char c : text) {
    open += c == '[' || c == '{' ? 1 : c == ']' || c == '}' ? -1 : 0;
    dots = c == '\n' ? 0 : dots + (c == '.' ? 1 : 0);
    if (open > kMaxOpen || dots > kMaxDots) {
      throw BadInput(fmt::format("{}: nests deeper than options do", source));
    }
  }
}

}  // namespace

void OptionCollector::operator()(std::string_view name, int& value, int low, int high,
                                 std::string_view doc) {
  fields_.push_back(
      {prefix_ + std::string(name), std::string(doc), RangedOption<int>{&value, low, high}});
}

void OptionCollector::operator()(std::string_view name, std::uint64_t& value, std::uint64_t low,
                                 std::uint64_t high, std::string_view doc) {
  const auto top = std::min(high, static_cast<std::uint64_t>(kLargestInteger));
  fields_.push_back({prefix_ + std::string(name), std::string(doc),
                     RangedOption<std::uint64_t>{&value, low, top}});
}

void OptionCollector::operator()(std::string_view name, double& value, double low, double high,
                                 std::string_view doc) {
  fields_.push_back(
      {prefix_ + std::string(name), std::string(doc), RangedOption<double>{&value, low, high}});
}

void OptionCollector::operator()(std::string_view name, bool& value, std::string_view doc) {
  fields_.push_back({prefix_ + std::string(name), std::string(doc), &value});
}

void OptionCollector::operator()(std::string_view name, std::string& value, std::string_view doc) {
  fields_.push_back({prefix_ + std::string(name), std::string(doc), &value});
}

std::vector<OptionField> OptionCollector::take() {
  std::ranges::stable_partition(
      fields_, [](const OptionField& field) { return !field.key.starts_with(kExpertSection); });
  return std::move(fields_);
}

void assign_toml(std::string_view text, std::string_view source,
                 const std::vector<OptionField>& fields, Earlier accept) {
  try {
    check_depth(text, source);
    assign_table(toml::parse(text), "", source, fields, accept);
  } catch (const toml::parse_error& error) {
    std::string reason(error.description());
    std::replace(reason.begin(), reason.end(), '\n', ' ');
    throw BadInput(place(source, error.source()) + reason);
  }
}

void assign_setting(std::string_view assignment, const std::vector<OptionField>& fields) {
  const auto equals = assignment.find('=');
  if (equals == std::string_view::npos) {
    throw BadInput(fmt::format("'{}' has no value: the form is KEY=VALUE", assignment));
  }
  if (trimmed(assignment.substr(0, equals)).empty()) {
    throw BadInput(fmt::format("'{}' has no key: the form is KEY=VALUE", assignment));
  }
  const OptionField& field =
      *find_field(trimmed(assignment.substr(0, equals)), fields, "", Earlier::refused);
  assign(field, written_in_setting(field, trimmed(assignment.substr(equals + 1))), "");
}

}  // namespace palpate
