// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "palpate/evaluation/trial.hpp"

namespace palpate::app {

/// Heading of the table of phases, and a row of it, for a person.
std::string phase_heading();
std::string phase_row(const skills::PhaseReport& report);

/// What became of the pick: the estimate, or why there is none.
/// @param names  of the candidates
std::string outcome_text(const evaluation::Trial& trial, const std::vector<std::string>& names);

/// The estimate in words: the best pose with its error, and the other modes.
std::string estimate_text(const evaluation::Trial& trial);

/// What `palpate pick --json` prints and report.json holds.
/// @param names  of the candidates
nlohmann::json trial_json(const evaluation::Trial& trial, const std::vector<std::string>& names);

}  // namespace palpate::app
