// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "common.hpp"
#include "palpate/evaluation/trial.hpp"

namespace palpate::app {

/// `eval --faults`: every fault, none at first, with every object; prints the table or the JSON,
/// and writes faults.json where there is a folder for it.
/// @param faults  hand::kInjectedFaultNames; empty: all of them
int eval_faults(const evaluation::TrialOptions& options, const CommonOptions& common,
                const std::vector<std::string>& objects, std::size_t trials,
                const std::vector<std::string>& faults, bool resume = false);

}  // namespace palpate::app
