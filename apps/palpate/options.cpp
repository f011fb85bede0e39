// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>

#include "common.hpp"
#include "palpate/core/error.hpp"

namespace palpate::app {
namespace {

/// A command and how its options are listed.
struct Listed {
  std::string_view command;
  std::vector<OptionInfo> (*options)();
};
constexpr Listed kListed[] = {
    {"pick", pick_option_list},         {"eval", pick_option_list},
    {"replay", replay_option_list},     {"localize", localize_option_list},
    {"register", register_option_list}, {"plan", plan_option_list},
    {"rollout", rollout_option_list}};

const Listed& listed(const std::string& command) {
  const auto* const found = std::find_if(std::begin(kListed), std::end(kListed),
                                         [&](const Listed& one) { return one.command == command; });
  if (found != std::end(kListed)) return *found;
  std::string names;
  for (const Listed& one : kListed)
    names += fmt::format("{}{}", names.empty() ? "" : ", ", one.command);
  throw BadInput(fmt::format("'{}' has no list of options; these have one: {}", command, names));
}

void print_json(const std::vector<OptionInfo>& options) {
  auto list = nlohmann::json::array();
  for (const OptionInfo& option : options) {
    list.push_back({{"key", option.key},
                    {"type", option.type},
                    {"default", option.value},
                    {"range", option.range},
                    {"help", option.doc}});
  }
  fmt::print("{}\n", nlohmann::json{{"options", list}}.dump(2));
}

void print_text(const std::vector<OptionInfo>& options) {
  std::size_t width = 0;
  for (const OptionInfo& option : options)
    width = std::max(width, option.key.size() + option.value.size());
  for (const OptionInfo& option : options) {
    const std::string range = option.range.empty() ? "" : fmt::format(" ({})", option.range);
    fmt::print("{:<{}}  {}{}\n", option.key + " = " + option.value, width + 3, option.doc, range);
  }
}

}  // namespace

void add_options(CLI::App& program, Command& chosen) {
  struct Arguments {
    CommonOptions common;
    std::string command = "pick";
    bool expert = false;
  };
  auto arguments = std::make_shared<Arguments>();
  auto& command = *program.add_subcommand("options", "List the options of --config and --set");
  command
      .add_option(
          "command", arguments->command,
          "command whose options to list: pick, eval, replay, localize, register, plan or rollout")
      ->capture_default_str();
  command.add_flag("--expert", arguments->expert, "list the expert section, too");
  add_common_options(command, arguments->common, 0);
  command.footer(
      "Each line is KEY = DEFAULT, what it is, and its range. Few users need the options of the\n"
      "expert section, and these may change from version to version.\n\n"
      "Examples:\n"
      "  palpate options pick\n"
      "  palpate options pick --expert\n"
      "  palpate options localize --json");
  command.callback([arguments, &chosen] {
    chosen = [arguments] {
      auto options = listed(arguments->command).options();
      if (!arguments->expert) {
        std::erase_if(options,
                      [](const OptionInfo& o) { return o.key.starts_with(kExpertSection); });
      }
      arguments->common.json ? print_json(options) : print_text(options);
      return kDone;
    };
  });
}

}  // namespace palpate::app
