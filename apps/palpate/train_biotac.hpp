// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "common.hpp"

namespace palpate::app {

/// The commands below `palpate train` for models of a BioTac: biotac-normal, biotac-electrodes,
/// biotac-network and biotac-inverse.
void add_train_biotac(CLI::App& train, Command& chosen);

std::vector<OptionInfo> biotac_electrodes_option_list();
/// Of biotac-network and biotac-inverse.
std::vector<OptionInfo> simulated_biotac_option_list();

}  // namespace palpate::app
