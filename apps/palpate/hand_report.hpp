// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json.hpp>

#include "palpate/simulation/hand/load_hand.hpp"

namespace palpate::app {

/// What is derived from a hand's file, what is assumed, and what is wrong with it.
nlohmann::json hand_json(const simulation::DescribedHand& loaded);

/// The same as tables, on stdout.
void print_hand(const simulation::DescribedHand& loaded);

}  // namespace palpate::app
