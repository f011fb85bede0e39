// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json.hpp>

#include "palpate/evaluation/trial.hpp"

namespace palpate::evaluation {

/// Of a trial, all that evaluate() and the tables of trials use, exactly: numbers come back bit for
/// bit. What a trial holds beyond (poses, motions, what was sensed) is left out.
nlohmann::json trial_to_json(const Trial& trial);

/// @throws BadInput or nlohmann::json::exception for what trial_to_json() did not write
Trial trial_from_json(const nlohmann::json& json);

}  // namespace palpate::evaluation
