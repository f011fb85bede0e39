// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>
#include <string>

#include "palpate/evaluation/evaluation.hpp"

namespace palpate::app {

/// The option --place.
void add_place_option(CLI::App& command, std::string& place);

/// The argument as options.place.target takes it: a file is read for the numbers in it.
/// @throws BadInput for an empty file
std::string place_text(const std::string& argument);

/// How placing went, for a person; ends with a newline where there is anything to say.
std::string place_text(const evaluation::Trial& trial);

/// Placing in report.json: null without.
nlohmann::json place_json(const evaluation::Trial& trial);

/// Placing in what `palpate eval --place` prints as JSON.
nlohmann::json place_summary_json(const evaluation::PlaceSummary& summary, std::size_t trials);

/// The table of `palpate eval --place`, for a person.
/// @param width  columns of the objects' names
std::string place_heading(std::size_t width);
std::string place_row(const std::string& name, std::size_t width,
                      const evaluation::PlaceSummary& summary, std::size_t trials);

/// Phases with their rates and times, for a person.
std::string phases_table(const std::map<std::string, evaluation::PhaseSummary>& phases);

}  // namespace palpate::app
