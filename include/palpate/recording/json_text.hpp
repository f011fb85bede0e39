// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <string_view>

namespace palpate::recording {

/// Levels of arrays and objects that a JSON text may nest. Code that walks over the value, that of
/// the library included, calls itself once a level.
inline constexpr int kMaxJsonDepth = 32;

/// The JSON value of a text. @throws BadInput if it is none, or nests deeper than kMaxJsonDepth
nlohmann::json parse_json(std::string_view text);

/// A value for a message: at most some 60 characters of it.
std::string shown(const nlohmann::json& value);

}  // namespace palpate::recording
