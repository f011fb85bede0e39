// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "common.hpp"

namespace palpate::app {

/// Adds `relocate` to the train command.
void add_train_relocate(CLI::App& train, Command& chosen);

std::vector<OptionInfo> train_relocate_option_list();

}  // namespace palpate::app
