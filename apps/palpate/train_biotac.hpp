// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "common.hpp"

namespace palpate::app {

/// The commands below `palpate train` for models of a BioTac: biotac-normal, biotac-network and
/// biotac-inverse.
void add_train_biotac(CLI::App& train, Command& chosen);

}  // namespace palpate::app
