// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>

#include "common.hpp"

namespace palpate::app {

using AddCommand = void (*)(CLI::App& program, Command& chosen);

/// The program with these commands. @return its exit code
int run_program(std::span<const AddCommand> commands, int argc, char** argv);

}  // namespace palpate::app
