// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <iterator>

#include "common.hpp"
#include "palpate/core/error.hpp"
#include "palpate/core/spelling.hpp"
#include "palpate/simulation/hand/describe_hand.hpp"
#include "palpate/tactile/biotac/normal.hpp"
#include "train_biotac.hpp"
#include "train_relocate.hpp"

namespace palpate::app {
namespace {

std::vector<OptionInfo> biotac_normal_list() {
  return list_options(tactile::BiotacNormalOptions{});
}

std::vector<OptionInfo> hand_notes_list() { return list_options(simulation::HandNotes{}); }

/// A command and how its options are listed.
struct Listed {
  std::string_view command;
  std::vector<OptionInfo> (*options)();
};
constexpr Listed kListed[] = {{"hand check", hand_notes_list},
                              {"pick", pick_option_list},
                              {"eval", pick_option_list},
                              {"render", pick_option_list},
                              {"replay", replay_option_list},
                              {"localize", localize_option_list},
                              {"register", register_option_list},
                              {"plan", plan_option_list},
                              {"rollout", rollout_option_list},
                              {"compare", compare_option_list},
                              {"train relocate", train_relocate_option_list},
                              {"train biotac-normal", biotac_normal_list},
                              {"train biotac-electrodes", biotac_electrodes_option_list},
                              {"train biotac-network", simulated_biotac_option_list},
                              {"train biotac-inverse", simulated_biotac_option_list},
                              {"demos make", demos_make_option_list},
                              {"demos retarget", demos_retarget_option_list},
                              {"ros2 estimate", ros2_estimate_option_list},
                              {"ros2 robot", pick_option_list},
                              {"ros2 pick", pick_option_list}};

/// The command, or all below it: of "train" those of each training.
std::vector<Listed> listed(const std::string& command) {
  std::vector<Listed> found;
  std::ranges::copy_if(kListed, std::back_inserter(found), [&](const Listed& one) {
    return one.command == command || one.command.starts_with(command + " ");
  });
  if (!found.empty()) return found;
  std::vector<std::string> names;
  for (const Listed& one : kListed) names.emplace_back(one.command);
  throw BadInput(fmt::format("'{}' has no list of options; these have one: {}{}", command,
                             fmt::join(names, ", "), did_you_mean(command, names)));
}

/// The options of one command.
struct List {
  std::string_view command;
  std::vector<OptionInfo> options;
};

List list_of(const Listed& listed, bool expert) {
  List list{listed.command, listed.options()};
  if (!expert) {
    std::erase_if(list.options,
                  [](const OptionInfo& o) { return o.key.starts_with(kExpertSection); });
  }
  return list;
}

void print_lists_as_json(const std::vector<List>& lists) {
  auto all = nlohmann::json::array();
  for (const auto& [command, options] : lists) {
    for (const OptionInfo& option : options) {
      all.push_back({{"command", command},
                     {"key", option.key},
                     {"type", option.type},
                     {"default", option.value},
                     {"range", option.range},
                     {"help", option.doc}});
    }
  }
  print_json(nlohmann::json{{"options", all}});
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

void print_text(const std::vector<List>& lists) {
  for (const auto& [command, options] : lists) {
    if (lists.size() > 1) fmt::print("palpate {}:\n", command);
    print_text(options);
    if (lists.size() > 1 && command != lists.back().command) fmt::print("\n");
  }
}

}  // namespace

void add_options(CLI::App& program, Command& chosen) {
  struct Arguments {
    CommonOptions common;
    std::vector<std::string> command = {"pick"};
    bool expert = false;
  };
  auto arguments = std::make_shared<Arguments>();
  auto& command = *program.add_subcommand("options", "List the options of --config and --set");
  command.add_option("command", arguments->command,
                     "command whose options to list (default: pick)");
  command.add_flag("--expert", arguments->expert, "list the expert section, too");
  add_common_options(command, arguments->common, 0);
  command.footer(
      "Each line is KEY = DEFAULT, what it is, and its range. Few users need the options of the\n"
      "expert section, and these may change from version to version.\n\n"
      "Examples:\n"
      "  palpate options pick\n"
      "  palpate options pick --expert\n"
      "  palpate options train relocate\n"
      "  palpate options localize --json");
  command.callback([arguments, &chosen] {
    chosen = [arguments] {
      std::vector<List> lists;
      for (const Listed& one : listed(fmt::format("{}", fmt::join(arguments->command, " "))))
        lists.push_back(list_of(one, arguments->expert));
      arguments->common.json ? print_lists_as_json(lists) : print_text(lists);
      return kDone;
    };
  });
}

}  // namespace palpate::app
