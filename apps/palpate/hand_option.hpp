// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <CLI/CLI.hpp>
#include <string>

#include "common.hpp"
#include "palpate/evaluation/trial.hpp"
#include "palpate/simulation/hand/load_hand.hpp"

namespace palpate::app {

CLI::Option& add_hand_option(CLI::App& command, std::string& hand);

/// A hand of a name or file, with a progress bar while its postures are searched for; it may have
/// none.
simulation::DescribedHand describe_hand_with_progress(const std::string& hand, bool quiet);

/// The same. @throws BadInput if it has no postures
simulation::DescribedHand load_hand_with_progress(const std::string& hand, bool quiet);

CLI::Option& add_arm_option(CLI::App& command, std::string& arm);

/// Options of a pick from --config, --set, --hand and --arm, with the hand loaded.
/// @param hand  of --hand; empty: that of the option world.hand
/// @param arm  of --arm; empty: that of the option arm.name
evaluation::TrialOptions resolve_trial(const CommonOptions& common, const std::string& hand,
                                       const std::string& arm = {});

}  // namespace palpate::app
