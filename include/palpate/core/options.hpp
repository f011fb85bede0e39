// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <limits>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

#include "palpate/core/file.hpp"

namespace palpate {

/// One option of a struct: where its value lives, its bounds and what it means.
struct OptionField {
  std::string key;  ///< with the sections that hold it: "grasp.side.pitch"
  std::variant<int*, double*, bool*, std::string*> value;
  double low = -std::numeric_limits<double>::infinity();
  double high = std::numeric_limits<double>::infinity();
  std::string doc;
};

/// Visitor that lists the options of a struct.
///
/// An options struct has `template <class Visitor> void visit(Visitor&& v)` that calls
/// v("name", member, low, high, "doc") for numbers, v("name", member, "doc") for the rest, and
/// v.section("name", member) for a struct of options.
class OptionLister {
 public:
  template <class Number>
  void operator()(std::string_view name, Number& value, double low, double high,
                  std::string_view doc) {
    fields_.push_back({prefix_ + std::string(name), &value, low, high, std::string(doc)});
  }
  template <class Value>
  void operator()(std::string_view name, Value& value, std::string_view doc) {
    OptionField field;
    field.key = prefix_ + std::string(name);
    field.value = &value;
    field.doc = doc;
    fields_.push_back(std::move(field));
  }
  template <class Options>
  void section(std::string_view name, Options& options) {
    const std::string outer = prefix_;
    prefix_ += std::string(name) + ".";
    options.visit(*this);
    prefix_ = outer;
  }
  std::vector<OptionField> take() { return std::move(fields_); }

 private:
  std::string prefix_;
  std::vector<OptionField> fields_;
};

/// All options of a struct, in the order of its visit().
template <class Options>
std::vector<OptionField> list_options(Options& options) {
  OptionLister lister;
  options.visit(lister);
  return lister.take();
}

/// Sets the listed options from a TOML file (its text, and its name for messages).
/// @throws BadInput for a syntax error, an unknown key (with the nearest known one), a value of the
///         wrong type or outside its range, each with the line
void load_toml_text(std::string_view text, const std::string& name,
                    const std::vector<OptionField>& fields);

/// Sets one option from "key=value". @throws BadInput as load_toml_text
void apply_setting_text(std::string_view assignment, const std::vector<OptionField>& fields);

/// TOML text of the listed options, with their meaning as comments.
std::string to_toml_text(const std::vector<OptionField>& fields);

/// Reads a TOML file into an options struct; keys that it lacks keep their values. If it throws,
/// the struct is as before.
template <class Options>
void load_toml(const std::filesystem::path& path, Options& options) {
  Options changed = options;
  load_toml_text(read_file(path), path.string(), list_options(changed));
  options = changed;
}

/// Sets one option of a struct from "section.key=value".
template <class Options>
void apply_setting(std::string_view assignment, Options& options) {
  Options changed = options;
  apply_setting_text(assignment, list_options(changed));
  options = changed;
}

/// TOML text of a struct's options.
template <class Options>
std::string to_toml(Options options) {
  return to_toml_text(list_options(options));
}

}  // namespace palpate
