// SPDX-License-Identifier: Apache-2.0
#include "hand_option.hpp"

#include <fmt/format.h>

#include <optional>

#include "given_command.hpp"
#include "palpate/core/error.hpp"
#include "palpate/simulation/hand/load_arm.hpp"
#include "progress_bar.hpp"

namespace palpate::app {

CLI::Option& add_hand_option(CLI::App& command, std::string& hand) {
  return *command
              .add_option(
                  "--hand", hand,
                  "a hand of `palpate hand list`, or an MJCF, URDF or TOML file (default: shadow)")
              ->option_text("HAND");
}

CLI::Option& add_arm_option(CLI::App& command, std::string& arm) {
  return *command
              .add_option("--arm", arm,
                          "what carries the hand: ur10, ur5, panda, floating, or an arm's MJCF "
                          "(default: floating)")
              ->option_text("ARM");
}

simulation::DescribedHand describe_hand_with_progress(const std::string& hand, bool quiet) {
  std::optional<ProgressBar> bar;
  return simulation::load_described_hand(hand, 4.0, [&](std::size_t done, std::size_t total) {
    if (!bar) bar.emplace(fmt::format("postures of {}", hand), total, quiet);
    bar->show(done);
  });
}

simulation::DescribedHand load_hand_with_progress(const std::string& hand, bool quiet) {
  auto loaded = describe_hand_with_progress(hand, quiet);
  if (loaded.failure.empty()) return loaded;
  throw BadInput(fmt::format("{}; `palpate hand check {} --render DIR` shows what was derived",
                             loaded.failure, quoted(hand)));
}

evaluation::TrialOptions resolve_trial(const CommonOptions& common, const std::string& hand,
                                       const std::string& arm) {
  auto options = resolve<evaluation::TrialOptions>(common);
  if (!hand.empty()) options.world.hand = hand;
  if (!arm.empty()) options.world.arm.name = arm;
  // Known to the process from now on; a bad name is reported before the objects are prepared.
  const auto described = load_hand_with_progress(options.world.hand, common.quiet);
  simulation::load_arm(options.world.arm, described.hand);
  return options;
}

}  // namespace palpate::app
