// SPDX-License-Identifier: Apache-2.0
#include "given_command.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <string_view>

#include "usage.hpp"

namespace palpate::app {
namespace {

bool is_left_out(const CLI::Option& option) {
  constexpr std::array<std::string_view, 4> kNames = {"--json", "--quiet", "--out", "--force"};
  return option.count() == 0 || std::ranges::find(kNames, option.get_name()) != kNames.end();
}

std::string words(const CLI::Option& option) {
  const std::string name = " " + option.get_name();
  if (option.get_expected_max() == 0) return name;  // a flag
  std::string values;
  for (const auto& value : option.results()) values += " " + quoted(value);
  if (!option.nonpositional()) return values;
  const int count = option.get_expected_max();
  if (count > 1 && count < CLI::detail::expected_max_vector_size) return name + values;
  std::string all;  // one of several values each with the name
  for (const auto& value : option.results()) all += fmt::format("{} {}", name, quoted(value));
  return all;
}

}  // namespace

std::string quoted(const std::string& word) {
  constexpr std::string_view kPlain =
      "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_-+=./,:@%";
  if (!word.empty() && word.find_first_not_of(kPlain) == word.npos) return word;
  std::string text = "'";
  for (const char c : word) text += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return text + "'";
}

std::string given_command(const CLI::App& command) {
  std::string positional, named;
  for (const CLI::Option* option : command.get_options()) {
    if (is_left_out(*option)) continue;
    (option->nonpositional() ? named : positional) += words(*option);
  }
  return fmt::format("palpate {}{}{}", words_of(&command), positional, named);
}

}  // namespace palpate::app
