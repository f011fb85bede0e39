// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <set>

#include "palpate/core/options.hpp"
#include "palpate/evaluation/trial.hpp"

namespace palpate::evaluation {
namespace {

/// Another value that the field may have, as text.
struct AnotherValue {
  std::string operator()(const bool* value) const { return *value ? "false" : "true"; }
  std::string operator()(const std::string* value) const { return *value + "another"; }
  template <class Number>
  std::string operator()(const RangedOption<Number>& option) const {
    return fmt::format("{}", *option.value == option.low ? option.high : option.low);
  }
};

/// Keys whose values differ.
std::set<std::string> changes(const std::vector<OptionInfo>& a, const std::vector<OptionInfo>& b) {
  std::set<std::string> keys;
  for (std::size_t i = 0; i < a.size(); ++i) {
    if (a[i].value != b[i].value) keys.insert(a[i].key);
  }
  return keys;
}

/// As a setting of the command line, and as the only line of a file.
TEST(TrialOptions, EachIsSetByItsKeyAloneAndChangesNoOther) {
  TrialOptions usual;
  const auto listed = list_options(usual);
  for (const OptionField& field : option_fields(usual)) {
    const std::string value = std::visit(AnotherValue{}, field.value);
    TrialOptions options;
    apply_setting(field.key + "=" + value, options);
    EXPECT_EQ(changes(listed, list_options(options)), std::set{field.key});

    const bool is_text = std::holds_alternative<std::string*>(field.value);
    TrialOptions read;
    parse_toml(field.key + " = " + (is_text ? "'" + value + "'" : value), "one.toml", read);
    EXPECT_EQ(to_toml(read), to_toml(options)) << field.key;
  }
}

TEST(TrialOptions, EachHasANameOfItsOwnAndIsExplained) {
  std::set<std::string> keys;
  for (const OptionInfo& option : list_options(TrialOptions{})) {
    EXPECT_TRUE(keys.insert(option.key).second) << option.key;
    EXPECT_GT(option.doc.size(), 10U) << option.key;
  }
  EXPECT_GT(keys.size(), 200U);
}

}  // namespace
}  // namespace palpate::evaluation
