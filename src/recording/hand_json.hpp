// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json.hpp>

#include "palpate/hand/description.hpp"

namespace palpate::recording {

nlohmann::json hand_to_json(const hand::Description& hand);

/// Reads what hand_to_json() wrote, or the hand of a recording older than version 4, which is a
/// Shadow hand and says nothing of its joints and actuators.
/// @throws BadInput or nlohmann::json::exception for a hand that cannot be
hand::Description hand_from_json(const nlohmann::json& json);

}  // namespace palpate::recording
