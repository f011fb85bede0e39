// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json.hpp>

#include "palpate/recording/recording.hpp"

namespace palpate::recording {

/// The header but for the object's mesh.
nlohmann::json to_json(const RecordingHeader& header);
/// @throws BadInput or nlohmann::json::exception for a value that is missing, of the wrong kind or
///         size, not finite, or out of its range
RecordingHeader header_from_json(const nlohmann::json& json);

nlohmann::json to_json(const Event& event);
Event event_from_json(const nlohmann::json& json);

nlohmann::json to_json(const EstimateRecord& estimate);
EstimateRecord estimate_from_json(const nlohmann::json& json);

nlohmann::json to_json(const BeliefRecord& belief);
BeliefRecord belief_from_json(const nlohmann::json& json);

}  // namespace palpate::recording
