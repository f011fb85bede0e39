// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <CLI/CLI.hpp>
#include <string>

namespace palpate::app {

/// The word as a shell reads it: in quotes where it needs them.
std::string quoted(const std::string& word);

/// The command as it was given, to be copied: "palpate localize box contacts.csv --table 0".
/// Without
/// --json, --quiet, --out and --force, which a next command has its own of.
std::string given_command(const CLI::App& command);

}  // namespace palpate::app
