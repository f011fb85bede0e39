// SPDX-License-Identifier: Apache-2.0
#include "usage.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>
#include <regex>
#include <sstream>

#include "palpate/core/spelling.hpp"

namespace palpate::app {
namespace {

constexpr std::string_view kProgramName = "palpate";
constexpr std::size_t kTextWidth = 70;  // columns of a description, right of the options' names

/// A type's name as CLI11 composes it, "FLOAT:0.001 to 5", at its colon.
struct TypeName {
  std::string type, limits;
};

TypeName type_name_of(const CLI::Option* option) {
  const std::string whole = option->get_type_name();
  const auto colon = whole.find(':');
  if (colon == std::string::npos) return {whole, ""};
  return {whole.substr(0, colon), whole.substr(colon + 1)};
}

bool is_whole_number(const CLI::Option* option) {
  const std::string type = type_name_of(option).type;
  return type == "INT" || type == "UINT";
}

bool is_choice(const std::string& limits) { return limits.starts_with('{'); }

std::string value_name(const CLI::Option* option) {
  if (!option->get_option_text().empty()) return option->get_option_text();
  auto [type, limits] = type_name_of(option);
  if (is_choice(limits)) {
    std::replace(limits.begin(), limits.end(), ',', '|');
    return limits.substr(1, limits.size() - 2);
  }
  if (is_whole_number(option)) return "N";
  return type == "FLOAT" ? "X" : type;
}

/// "default: 40; 1 to 64", without what the description says itself.
std::string default_and_range(const CLI::Option* option) {
  std::string value = option->get_default_str();
  if (value.starts_with('[')) value = value.substr(1, value.size() - 2);
  if (option->get_type_size() == 0 ||
      option->get_description().find("default") != std::string::npos) {
    value.clear();
  }
  const std::string limits = type_name_of(option).limits;
  std::string range = is_choice(limits) ? "" : limits;
  if (value.empty()) return range;
  return fmt::format("default: {}{}{}", value, range.empty() ? "" : "; ", range);
}

std::string wrapped(const std::string& text) {
  std::istringstream words(text);
  std::string lines, word;
  for (std::size_t column = 0; words >> word; column += word.size()) {
    if (column > 0 && column + 1 + word.size() > kTextWidth) {
      lines += '\n';
      column = 0;
    } else if (column > 0) {
      lines += ' ';
      ++column;
    }
    lines += word;
  }
  return lines;
}

template <class Number>
std::string range_error(const std::string& text, Number min, Number max, std::string_view kind) {
  Number value{};
  const char* const end = text.data() + text.size();
  const auto [rest, error] = std::from_chars(text.data(), end, value);
  if (error == std::errc::result_out_of_range && rest == end) {
    return fmt::format("{} is beyond the largest number possible", text);
  }
  if (error != std::errc() || rest != end) return fmt::format("'{}' is not {}", text, kind);
  if (value >= min && value <= max) return "";
  if (max == std::numeric_limits<Number>::max()) return fmt::format("{} is below {}", text, min);
  return fmt::format("{} is outside {} to {}", text, min, max);
}

/// Digits without the zeros in front of them; any other text as it is.
std::string without_leading_zeros(const std::string& text) {
  const std::size_t start = text.starts_with('-') ? 1 : 0;
  if (text.find_first_not_of("0123456789", start) != text.npos) return text;
  const std::size_t first = text.find_first_not_of('0', start);
  if (first != text.npos) return text.substr(0, start) + text.substr(first);
  return text.size() > start ? "0" : text;
}

std::string command_path(const CLI::App* command) {
  return command->get_parent() ? fmt::format("{} {}", kProgramName, words_of(command))
                               : std::string(kProgramName);
}

std::vector<std::string> command_names(const CLI::App* app) {
  std::vector<std::string> names;
  for (const auto* command : app->get_subcommands([](const CLI::App*) { return true; })) {
    names.push_back(command->get_name());
  }
  return names;
}

std::vector<std::string> option_names(const CLI::App* app) {
  std::vector<std::string> names;
  for (const auto* option : app->get_options()) {
    if (option->nonpositional()) names.push_back(option->get_name());
  }
  return names;
}

std::string in_capitals(std::string text) {
  std::ranges::transform(text, text.begin(), [](unsigned char c) { return std::toupper(c); });
  return text;
}

/// Positional arguments in a message are named as in the usage.
std::string with_positionals_in_capitals(std::string text, const CLI::App* command) {
  for (const auto* option : command->get_options()) {
    if (option->nonpositional()) continue;
    const std::string name = option->get_name();
    text = std::regex_replace(text, std::regex("(^|\\s)" + name + "(?=\\s|:|$)"),
                              "$1" + in_capitals(name));
  }
  return text;
}

/// "--method: quick not in {fast,full}" as a sentence, with the likeliest of them.
std::string named_choices(const std::string& text) {
  static const std::regex kPattern(R"((.*): (.*) not in \{(.*)\})");
  std::smatch match;
  if (!std::regex_match(text, match, kPattern)) return text;
  const std::string list = match[3];
  const std::vector<std::string> names = CLI::detail::split(list, ',');
  return fmt::format("{}: '{}' is none of {}{}", match[1].str(), match[2].str(),
                     fmt::join(names, ", "), did_you_mean(match[2].str(), names));
}

/// "Could not convert: --distance = 1,5" as a sentence.
std::string unconverted(const std::string& text, const CLI::App* command) {
  static const std::regex kPattern("Could not convert: (\\S+) = (.*)");
  std::smatch match;
  if (!std::regex_match(text, match, kPattern)) return text;
  const CLI::Option* const option = command->get_option_no_throw(match[1]);
  const bool is_flag = option && option->get_expected_max() == 0;
  return fmt::format("{}: '{}' is not {}", match[1].str(), match[2].str(),
                     is_flag ? "true or false" : "a number");
}

/// "RECORDING: At Most 2 required but received 3" or "--seed: 1 required N:at least 0 missing" as a
/// sentence.
std::string counted(const std::string& text) {
  static const std::regex kMissing(R"((.*?): 1 required .* missing)");
  static const std::regex kTooFew(R"((.*): At least (\d+) required but received (\d+))");
  static const std::regex kPattern(R"((.*): At Most (\d+) required but received (\d+))");
  std::string result =
      std::regex_replace(text, kPattern, "$1: at most $2 are possible, $3 are given");
  result = std::regex_replace(result, kMissing, "$1 needs a value");
  return std::regex_replace(result, kTooFew, "$1 needs $2 values, and has $3");
}

/// A long argument without its middle: on all of it the regular expressions run out of stack.
std::string without_middle(const std::string& text) {
  constexpr std::size_t kEnd = 500;
  if (text.size() <= 2 * kEnd) return text;
  return text.substr(0, kEnd) + "..." + text.substr(text.size() - kEnd);
}

std::string without_dashes(const std::string& option) {
  return option.substr(std::min(option.size(), option.find_first_not_of('-')));
}

/// "; did you mean '--seed'?" for what resembles an option; dashes make no two of them alike.
std::string likely_option(const CLI::App* command, const std::string& argument) {
  std::vector<std::string> names = option_names(command);
  std::ranges::transform(names, names.begin(), without_dashes);
  std::string text = did_you_mean(without_dashes(argument), names);
  if (!text.empty()) text.insert(text.find('\'') + 1, "--");
  return text;
}

bool has_positionals(const CLI::App* command) {
  return !command->get_options([](const CLI::Option* o) { return !o->nonpositional(); }).empty();
}

/// What is wrong with the first argument that a command does not know.
std::string unexpected(const CLI::App* command, const std::string& argument) {
  const std::string name = command_path(command);
  if (argument.starts_with("-")) {
    if (command->get_option_no_throw(argument)) {
      return fmt::format("{} stands before the command; it goes after {}", argument, name);
    }
    const std::string which =
        command->get_parent() ? name + " has no option " : std::string("there is no option ");
    return which + argument + likely_option(command, argument);
  }
  if (command_names(command).empty()) {
    const bool is_object = command->get_option_no_throw("--object") && !has_positionals(command);
    return fmt::format("{} takes no argument '{}'{}", name, argument,
                       is_object ? fmt::format("; did you mean --object {}?", argument) : "");
  }
  const std::string whole = name + " " + argument;
  const std::string likely = did_you_mean(argument, command_names(command));
  return fmt::format("there is no command '{}'{}", whole.substr(kProgramName.size() + 1),
                     likely.empty() ? fmt::format("; the commands{} are {}",
                                                  command->get_parent() ? " of " + name : "",
                                                  fmt::join(command_names(command), ", "))
                                    : likely);
}

}  // namespace

std::string HelpFormatter::make_option_name(const CLI::Option* option, bool is_positional) const {
  const std::string name = Formatter::make_option_name(option, is_positional);
  return is_positional ? in_capitals(name) : name;
}

std::string HelpFormatter::make_option_usage(const CLI::Option* option) const {
  std::string usage = Formatter::make_option_usage(option);
  if (const auto count = usage.find("(0x)"); count != std::string::npos) {
    usage.replace(count, 4, "...");  // CLI11's least number of what may be missing
  }
  const std::string name = option->get_name(true);
  return std::regex_replace(usage, std::regex(name), in_capitals(name));
}

std::string HelpFormatter::make_option_opts(const CLI::Option* option) const {
  if (option->get_type_size() == 0) return "";
  const bool many = option->get_expected_max() == CLI::detail::expected_max_vector_size;
  if (!option->nonpositional()) return many ? "..." : "";
  const std::string text = value_name(option);
  return (text.empty() ? "" : " " + text) +
         (many && option->get_option_text().empty() ? "..." : "");
}

std::string HelpFormatter::make_option_desc(const CLI::Option* option) const {
  const std::string more = default_and_range(option);
  return wrapped(option->get_description() + (more.empty() ? "" : fmt::format(" ({})", more)));
}

std::string HelpFormatter::make_subcommand(const CLI::App* command) const {
  std::ostringstream line;
  CLI::detail::format_help(line, command->get_name(), wrapped(command->get_description()),
                           column_width_);
  return line.str();
}

CLI::Validator in_range(double min, double max) {
  return {[min, max](const std::string& text) { return range_error(text, min, max, "a number"); },
          fmt::format("{} to {}", min, max)};
}

CLI::Validator in_range(int min, int max) {
  return {[min, max](const std::string& text) {
            return range_error<std::int64_t>(text, min, max, "a whole number");
          },
          fmt::format("{} to {}", min, max)};
}

CLI::Validator at_least(std::int64_t min) {
  return {[min](const std::string& text) {
            return range_error(text, min, std::numeric_limits<std::int64_t>::max(),
                               "a whole number");
          },
          fmt::format("at least {}", min)};
}

CLI::Validator positive() {
  return {[](const std::string& text) -> std::string {
            double value = 0;
            const char* const end = text.data() + text.size();
            const auto [rest, error] = std::from_chars(text.data(), end, value);
            const bool is_number = error == std::errc() && rest == end && std::isfinite(value);
            if (is_number && value > 0) return "";
            return fmt::format("'{}' is not a positive number", text);
          },
          "above 0"};
}

void check_values(CLI::App& program) {
  for (CLI::Option* const option : program.get_options()) {
    if (is_whole_number(option)) option->transform(without_leading_zeros);
    option->transform(CLI::Validator(  // comes first
        [](const std::string& text) { return text.empty() ? "the value is empty" : ""; }, ""));
  }
  for (CLI::App* const command : program.get_subcommands([](const CLI::App*) { return true; })) {
    check_values(*command);
  }
}

const CLI::App* innermost(const CLI::App* program) {
  while (!program->get_subcommands().empty()) program = program->get_subcommands().front();
  return program;
}

std::string words_of(const CLI::App* command) {
  const CLI::App* const parent = command->get_parent();
  if (!parent) return "";
  return parent->get_parent() ? words_of(parent) + " " + command->get_name() : command->get_name();
}

std::string in_one_line(std::string text) {
  for (char& c : text) {
    if (c == '\n' || c == '\r') c = ' ';
    if (c != '\t' && std::iscntrl(static_cast<unsigned char>(c)) != 0) c = '?';
  }
  return text;
}

std::string usage_error(const CLI::App* program, const CLI::Error& error) {
  const CLI::App* const command = innermost(program);
  const auto unknown = program->remaining(true);
  std::string what = with_positionals_in_capitals(
      counted(unconverted(named_choices(without_middle(error.what())), command)), command);
  const auto option =
      std::ranges::find_if(unknown, [](const auto& a) { return a.starts_with("-"); });
  // What seems to be missing may be there, misspelt.
  const bool is_unread = dynamic_cast<const CLI::RequiredError*>(&error) &&
                         (!command_names(command).empty() || option != unknown.end());
  if (is_unread || dynamic_cast<const CLI::ExtrasError*>(&error)) {
    if (unknown.empty()) {
      what = "no command is given";
    } else {
      what = unexpected(command, option == unknown.end() ? unknown.front() : *option);
    }
  }
  return in_one_line(fmt::format("palpate: {}; see {} --help", what, command_path(command))) + "\n";
}

}  // namespace palpate::app
