// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <CLI/CLI.hpp>
#include <cstdint>
#include <limits>
#include <string>
#include <vector>

namespace palpate::app {

/// Help as text of at most 100 columns: each option with the name of its value, and after its
/// description its default and its range. Positional arguments are in capitals.
class HelpFormatter : public CLI::Formatter {
 public:
  std::string make_option_name(const CLI::Option* option, bool is_positional) const override;
  std::string make_option_usage(const CLI::Option* option) const override;
  std::string make_option_opts(const CLI::Option* option) const override;
  std::string make_option_desc(const CLI::Option* option) const override;
  std::string make_subcommand(const CLI::App* command) const override;
};

/// Accepts a number within limits, else says which number is outside which limits.
CLI::Validator in_range(double min, double max);
/// The same for whole numbers.
CLI::Validator in_range(int min, int max);
/// Whole numbers from a least one on.
CLI::Validator at_least(std::int64_t min);

/// Has all options, those of the commands included, refuse an empty value, as that of a shell's
/// variable that is not set, and those of whole numbers read 010 as 10: CLI11 takes a leading 0 for
/// the mark of octal numbers.
void check_values(CLI::App& program);

/// Any number above 0 that is finite.
CLI::Validator positive();

/// A message in which what was given stands as it is, but for the ends of lines and the control
/// characters that a terminal obeys.
std::string in_one_line(std::string text);

/// One line on stderr for a command line that cannot be read.
std::string usage_error(const CLI::App* program, const CLI::Error& error);

/// The command that was chosen, with those it belongs to: "train relocate".
const CLI::App* innermost(const CLI::App* program);

/// The words of a command after the program's name: "train relocate".
std::string words_of(const CLI::App* command);

}  // namespace palpate::app
