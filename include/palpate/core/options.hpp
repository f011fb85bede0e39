// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

#include "palpate/core/file.hpp"

namespace palpate {

/// A number of an options struct and the range it must stay in, ends included.
template <class Number>
struct RangedOption {
  Number* value;
  Number low, high;
};

/// One member of an options struct, nested ones included.
struct OptionField {
  std::string key;  ///< with its sections, as in "lift.speed", or "expert.lift.settle"
  std::string doc;
  std::variant<bool*, std::string*, RangedOption<int>, RangedOption<std::uint64_t>,
               RangedOption<double>>
      value;
};

/// What a user needs to know of one option.
struct OptionInfo {
  std::string key, type, value, range, doc;  ///< type: "bool", "string", "integer" or "number"
};

inline constexpr std::string_view kExpertSection = "expert.";

/// The visitor that lists an options struct's members; they stay owned by the struct.
class OptionCollector {
 public:
  void operator()(std::string_view name, int& value, int low, int high, std::string_view doc);
  void operator()(std::string_view name, std::uint64_t& value, std::uint64_t low,
                  std::uint64_t high, std::string_view doc);
  void operator()(std::string_view name, double& value, double low, double high,
                  std::string_view doc);
  void operator()(std::string_view name, bool& value, std::string_view doc);
  void operator()(std::string_view name, std::string& value, std::string_view doc);

  template <class Options>
  void section(std::string_view name, Options& nested) {
    const std::string outer = prefix_;
    prefix_ += std::string(name) + ".";
    nested.visit(*this);
    prefix_ = outer;
  }

  /// As operator(), of an option in the expert section: few users need it, and it may change.
  template <class... Option>
  void expert(std::string_view name, Option&&... option) {
    in_expert_section([&] { (*this)(name, option...); });
  }
  template <class Options>
  void expert_section(std::string_view name, Options& nested) {
    in_expert_section([&] { section(name, nested); });
  }

  /// In the order of their visit, but the expert section last.
  std::vector<OptionField> take();

 private:
  template <class Add>
  void in_expert_section(const Add& add) {
    const std::string outer = prefix_;
    if (!outer.starts_with(kExpertSection)) prefix_.insert(0, kExpertSection);
    add();
    prefix_ = outer;
  }

  std::string prefix_;
  std::vector<OptionField> fields_;
};

/// All members of an options struct, in the order of its visit(), which calls
/// v("name", member, low, high, "doc with unit") for numbers, v("name", member, "doc") for bool and
/// std::string, and v.section("name", nested) for nested structs; v.expert and v.expert_section do
/// the same below "expert.".
template <class Options>
std::vector<OptionField> option_fields(Options& options) {
  OptionCollector collector;
  options.visit(collector);
  return collector.take();
}

/// Whether options of earlier versions may be given: by the names that they had then, and, without
/// effect, those that are gone.
enum class Earlier { refused, accepted };

/// Sets the fields that a TOML text names. @param source  named in errors, as in "run.toml:3: ..."
void assign_toml(std::string_view text, std::string_view source,
                 const std::vector<OptionField>& fields, Earlier accept = Earlier::refused);
/// Sets the one field that "section.key=value" names.
void assign_setting(std::string_view assignment, const std::vector<OptionField>& fields);
std::string fields_to_toml(const std::vector<OptionField>& fields);
std::vector<OptionInfo> describe(const std::vector<OptionField>& fields);

/// Sets the options that a TOML text names; the others keep their values.
/// @param source  where the text is from; errors start with "source:line: "
/// @throws BadInput for a syntax error, an unknown key (naming the nearest), a value of the wrong
///         type or outside its range, an option that has another name now (naming it) or is gone
///         (saying why) unless that is accepted; `options` is then unchanged
template <class Options>
void parse_toml(std::string_view text, std::string_view source, Options& options,
                Earlier accept = Earlier::refused) {
  Options copy = options;
  assign_toml(text, source, option_fields(copy), accept);
  options = std::move(copy);
}

/// As parse_toml, from a file. @throws BadInput also if the file cannot be read
template <class Options>
void load_toml(const std::filesystem::path& path, Options& options) {
  parse_toml(read_file(path), path.string(), options);
}

/// Sets one option from "section.key=value"; a string's value is taken as it stands, unquoted.
/// @throws BadInput as parse_toml, and if there is no "="; `options` is then unchanged
template <class Options>
void apply_setting(std::string_view assignment, Options& options) {
  assign_setting(assignment, option_fields(options));
}

/// TOML text of all options, with their docs and ranges as comments; parse_toml reads it back
/// exactly.
template <class Options>
std::string to_toml(Options options) {
  return fields_to_toml(option_fields(options));
}

/// Every option with its type, value, range and doc.
template <class Options>
std::vector<OptionInfo> list_options(Options options) {
  return describe(option_fields(options));
}

}  // namespace palpate
